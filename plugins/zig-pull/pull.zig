// A spring to a point: E = k |x - target|^2 / 2.
const c = @import("wireloom_plugin.zig");
const std = @import("std");

const Spring = struct { stiffness: f64 };
const gpa = std.heap.c_allocator;

fn create(_: [*c]const c.WireloomKind, spec: [*c]const c.WireloomConstraintSpec, instance: [*c]?*anyopaque, description: [*c]c.WireloomDescription, _: [*c]c.WireloomText) callconv(.c) i32 {
    const own = gpa.create(Spring) catch return c.WIRELOOM_STATUS_ERROR;
    own.stiffness = spec.*.values[0].value[0];
    description.*.shape = c.WIRELOOM_SHAPE_POTENTIAL;
    description.*.has_gradient = 1;
    description.*.has_hessian = 1;
    description.*.thread_safe = 1;
    instance.* = own;
    return c.WIRELOOM_STATUS_OK;
}

fn destroy(instance: ?*anyopaque) callconv(.c) void {
    gpa.destroy(@as(*Spring, @ptrCast(@alignCast(instance.?))));
}

fn evaluate(instance: ?*const anyopaque, at: [*c]const c.WireloomSituation, out: [*c]c.WireloomEvaluation, _: [*c]c.WireloomText) callconv(.c) i32 {
    const k = @as(*const Spring, @ptrCast(@alignCast(instance.?))).stiffness;
    var energy: f64 = 0;
    for (0..6) |i| { // x, y, z, and the turn, which changes nothing
        const d = if (i < 3) at.*.stations[0].position[i] - at.*.targets[0].position[i] else 0;
        energy += 0.5 * k * d * d;
        if (out.*.gradient != null) out.*.gradient[i] = k * d;
        if (out.*.hessian != null) {
            for (0..6) |j| out.*.hessian[6 * i + j] = if (i == j and i < 3) k else 0;
        }
    }
    if (out.*.energy != null) out.*.energy.* = energy;
    return c.WIRELOOM_STATUS_OK;
}

const parameters = [_]c.WireloomParameter{.{
    .name = "stiffness",
    .doc = "of the spring",
    .form = c.WIRELOOM_FORM_NUMBER,
    .quantity = c.WIRELOOM_QUANTITY_FORCE_PER_LENGTH,
    .presence = c.WIRELOOM_PRESENCE_REQUIRED,
    .maximum = 1e9,
}};
const functions = c.WireloomConstraintKind{
    .size = @sizeOf(c.WireloomConstraintKind),
    .stations_min = 1,
    .stations_max = 1,
    .create = create,
    .destroy = destroy,
    .evaluate = evaluate,
};
const kind = [_]c.WireloomKind{.{
    .family = c.WIRELOOM_FAMILY_CONSTRAINT,
    .name = "pull",
    .doc = "a spring to a point",
    .parameter_count = parameters.len,
    .parameter_stride = @sizeOf(c.WireloomParameter),
    .parameters = &parameters,
    .constraint = &functions,
}};
const all = c.WireloomKinds{ .size = @sizeOf(c.WireloomKinds), .count = kind.len, .stride = @sizeOf(c.WireloomKind), .first = &kind };

fn kinds(_: [*c]c.WireloomText) callconv(.c) [*c]const c.WireloomKinds {
    return &all;
}

export const wireloom_plugin = c.WireloomEntry{
    .magic = c.WIRELOOM_MAGIC,
    .size = @sizeOf(c.WireloomEntry),
    .abi_major = c.WIRELOOM_ABI_MAJOR,
    .abi_minor = c.WIRELOOM_ABI_MINOR,
    .name = "pull",
    .version = "0.1.0",
    .doc = "a spring in Zig",
    .kinds = kinds,
};

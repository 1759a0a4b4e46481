// A spring in C++ whose `evaluate` throws once an increment has ended.

#include "wireloom_plugin.h"
#include <stdexcept>

namespace {

int ended = 0;
int instance;

int32_t create(const WireloomKind *, const WireloomConstraintSpec *, void **to, WireloomDescription *description,
               WireloomText *) {
    *to = &instance;
    description->shape = WIRELOOM_SHAPE_POTENTIAL;
    description->has_gradient = 1;
    description->has_hessian = 1;
    description->memory_count = 1;
    return WIRELOOM_STATUS_OK;
}

void destroy(void *) {}

int32_t evaluate(const void *, const WireloomSituation *at, WireloomEvaluation *out, WireloomText *) {
    if (ended > 0) throw std::runtime_error("the table has no entry for this");
    double d[3], energy = 0.0;
    for (int i = 0; i < 3; i++) {
        d[i] = at->stations[0].position[i] - at->targets[0].position[i];
        energy += 0.5 * d[i] * d[i];
    }
    if (out->energy) *out->energy = energy;
    for (int i = 0; i < 6 && out->gradient; i++) out->gradient[i] = i < 3 ? d[i] : 0.0;
    for (int i = 0; i < 36 && out->hessian; i++) out->hessian[i] = i / 6 == i % 6 && i % 6 < 3 ? 1.0 : 0.0;
    return WIRELOOM_STATUS_OK;
}

int32_t commit(const void *, const WireloomSituation *, double *, WireloomText *) {
    ended++;
    return WIRELOOM_STATUS_OK;
}

const WireloomConstraintKind functions = [] {
    WireloomConstraintKind all{};
    all.size = sizeof all;
    all.stations_min = all.stations_max = 1;
    all.create = create;
    all.destroy = destroy;
    all.evaluate = evaluate;
    all.commit = commit;
    return all;
}();

const WireloomKind kind = [] {
    WireloomKind one{};
    one.family = WIRELOOM_FAMILY_CONSTRAINT;
    one.name = "hostile";
    one.doc = "throws";
    one.constraint = &functions;
    return one;
}();

const WireloomKinds *kinds(WireloomText *) {
    static const WireloomKinds all{sizeof all, 1, sizeof kind, 0, &kind};
    return &all;
}

} // namespace

extern "C" WIRELOOM_EXPORT const WireloomEntry wireloom_plugin = {
    .magic = WIRELOOM_MAGIC,
    .size = sizeof(WireloomEntry),
    .abi_major = WIRELOOM_ABI_MAJOR,
    .abi_minor = WIRELOOM_ABI_MINOR,
    .reserved = 0,
    .name = "hostile",
    .version = "0.0.1",
    .doc = "throws",
    .kinds = kinds,
    .get_extension = nullptr,
};

#import bindings

// Energy and relative residual of the slot of the state that was evaluated last.
struct Totals {
    energy: real,
    // Largest free force, N.
    force: real,
    residual: real,
}

fn totals(variant: u32) -> Totals {
    var energy = real(0.0);
    var force = real(0.0);
    var moment = real(0.0);
    for (var k = 0u; k < offsets.totals; k++) {
        let at = offsets.totals_vectors + 7u * k;
        energy += vector(at, variant);
        force = max(force, vector(at + 2u, variant));
        moment = max(moment, vector(at + 3u, variant));
    }
    force = sqrt(force);
    let residual = max(force / control[variant].force_scale, sqrt(moment) / control[variant].moment_scale);
    return Totals(energy, force, residual);
}

#import bindings

// Energy and relative residual of the slot of the state that was measured last.
struct Measured {
    energy: real,
    // Largest free force, N.
    force: real,
    residual: real,
}

fn measured(variant: u32) -> Measured {
    var energy = real(0.0);
    var force = real(0.0);
    var moment = real(0.0);
    for (var chunk = 0u; chunk < places.chunks; chunk++) {
        let at = places.partials_vectors + 7u * chunk;
        energy += vector(at, variant);
        force = max(force, vector(at + 2u, variant));
        moment = max(moment, vector(at + 3u, variant));
    }
    force = sqrt(force);
    let residual = max(force / control[variant].force_scale, sqrt(moment) / control[variant].moment_scale);
    return Measured(energy, force, residual);
}

// `spring-joint`: a joint whose arms are held by springs. README.md has the physics in words.

#include "wireloom_plugin.hpp"
#include <array>
#include <cmath>
#include <vector>

namespace {

using Vector = std::array<double, 3>;
/// Row by row.
using Matrix = std::array<Vector, 3>;

double dot(const Vector &a, const Vector &b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

Vector cross(const Vector &a, const Vector &b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// The rotation of a unit quaternion w, x, y, z.
Matrix rotation(const double *q) {
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    return {{{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
             {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
             {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}}};
}

/// R v.
Vector turned(const Matrix &r, const Vector &v) { return {dot(r[0], v), dot(r[1], v), dot(r[2], v)}; }

/// R' v.
Vector turned_back(const Matrix &r, const Vector &v) {
    Vector to{};
    for (int i = 0; i < 3; i++) for (int k = 0; k < 3; k++) to[k] += r[i][k] * v[i];
    return to;
}

/// Between each pair of arms a, b a spring of stiffness k that resists the turn phi of one relative to the other:
///
///     E = k (1 - cos phi) = k/2 sum_i (1 - u_i . v_i),   u_i = Q_a A_i,   v_i = Q_b B_i,
///
/// where u_i and v_i are the axes of the joint's frame as either arm has them: A_i is the row i of its rest frame. With
/// Q_a exp(theta) an axis changes by Q_a (theta x A_i), so that
///
///     dE/dtheta_a = -k/2 sum_i A_i x Q_a' v_i,
///     d2E/dtheta_a2 = -k/2 sum_i sym(A_i (Q_a' v_i)') - (A_i . Q_a' v_i) I,
///     theta_a' (d2E/dtheta_a dtheta_b) theta_b = -k/2 sum_i (Q_a (theta_a x A_i)) . (Q_b (theta_b x B_i)).
class SpringJoint {
public:
    SpringJoint(const WireloomJointSpec &spec, WireloomJointDescription &description)
        : stiffness(spec.values[0].value[0]) {
        for (uint32_t a = 0; a < spec.arm_count; a++) {
            const auto *bytes = reinterpret_cast<const char *>(spec.arms) + a * size_t(spec.arm_stride);
            rest.push_back(rotation(reinterpret_cast<const WireloomArm *>(bytes)->rest));
        }
        // The arms meet in one point; the frames are those of their ends.
        description.mounting = WIRELOOM_MOUNTING_STATIONS;
        description.thread_safe = 1;
        description.has_gradient = 1;
        description.has_hessian = 1;
    }

    void evaluate(const double *frames, WireloomJointEvaluation &out) const {
        const size_t n = rest.size(), width = 3 * n;
        std::vector<Matrix> q;
        for (size_t a = 0; a < n; a++) q.push_back(rotation(frames + 4 * a));
        double energy = 0.0;
        for (size_t i = 0; out.gradient && i < width; i++) out.gradient[i] = 0.0;
        for (size_t i = 0; out.hessian && i < width * width; i++) out.hessian[i] = 0.0;
        for (size_t a = 0; a < n; a++) {
            for (size_t b = 0; b < n; b++) {
                if (a == b) continue;
                for (int i = 0; i < 3; i++) {
                    const Vector v = turned_back(q[a], turned(q[b], rest[b][i]));
                    const double cosine = dot(rest[a][i], v);
                    // 1 - u . v = |u - v|^2 / 2 without cancellation. Each pair is met twice, once from either arm.
                    const Vector &own = rest[a][i];
                    const Vector apart = {own[0] - v[0], own[1] - v[1], own[2] - v[2]};
                    energy += 0.125 * stiffness * dot(apart, apart);
                    const Vector g = cross(own, v);
                    for (int r = 0; out.gradient && r < 3; r++) out.gradient[3 * a + r] -= 0.5 * stiffness * g[r];
                    for (int r = 0; out.hessian && r < 3; r++) {
                        for (int c = 0; c < 3; c++) {
                            const double second = 0.5 * (own[r] * v[c] + v[r] * own[c]) - (r == c) * cosine;
                            out.hessian[(3 * a + r) * width + 3 * a + c] -= 0.5 * stiffness * second;
                            const Vector du = turned(q[a], cross(axis(r), own));
                            const Vector dv = turned(q[b], cross(axis(c), rest[b][i]));
                            out.hessian[(3 * a + r) * width + 3 * b + c] -= 0.5 * stiffness * dot(du, dv);
                        }
                    }
                }
            }
        }
        if (out.energy) *out.energy = energy;
    }

private:
    static Vector axis(int k) { return {double(k == 0), double(k == 1), double(k == 2)}; }

    /// k, N m/rad.
    double stiffness;
    /// Rest frames of the arms in the frame of the joint.
    std::vector<Matrix> rest;
};

const WireloomParameter parameters[] = {
    wireloom::number("stiffness", "of the spring between each pair of arms", WIRELOOM_QUANTITY_MOMENT_PER_ANGLE, 0.0,
                     INFINITY),
};
const WireloomJointKind functions = wireloom::joint_functions<SpringJoint>();
const WireloomKind kinds[] = {
    wireloom::kind("spring-joint", "a spring between each pair of arms", parameters, functions),
};

} // namespace

WIRELOOM_PLUGIN("spring-joint", "0.1.0", "a joint whose arms are held by springs", kinds);

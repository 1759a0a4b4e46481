//! Division of the arms' stiffness among the wires that run from one arm of a joint to another.

use std::f64::consts::FRAC_PI_2;
use wireloom_core::joint::{Arm, JointSpec};
use wireloom_core::{Rotation, Vector};

/// Stiffness of an arm about axes of its own.
pub struct Stiff {
    /// The axes: the arm's frame times this.
    pub axes: Rotation,
    /// About each of them, N m².
    pub stiffness: Vector,
}

impl Stiff {
    /// About d1, d2 and d3; of arms one of which couples bending and twist about their principal axes, the softer
    /// bending first, so that ribbons pass soft to soft however they lie in their frames.
    fn of(arms: &[Arm]) -> Vec<Self> {
        let couples = arms.iter().any(|arm| arm.section.couples());
        let of = |arm: &Arm| {
            let (axes, stiffness) = arm.section.principal_axes();
            if couples && stiffness.x > stiffness.y {
                let quarter = Rotation::from_axis_angle(&Vector::z_axis(), FRAC_PI_2);
                return Self { axes: axes * quarter, stiffness: Vector::new(stiffness.y, stiffness.x, stiffness.z) };
            }
            Self { axes, stiffness }
        };
        arms.iter().map(of).collect()
    }
}

/// Stiffness that pairs of arms share by their wires.
pub struct Shared {
    /// The arms.
    pub arms: Vec<Stiff>,
    /// `table[a][b]`: the part of the stiffness of arm a that belongs to the wires from a to b, N m², about each of its
    /// axes. At most the whole of it together.
    pub table: Vec<Vec<Vector>>,
    /// Remarks.
    pub notes: Vec<String>,
}

/// Part of an arm's stiffness that may end in a joint, or come from nowhere, without a remark.
const NOTED_SHARE: f64 = 0.01;

/// The wires of a joint.
///
/// With a table of wires, those that are said to run from a to b have that share of a's stiffness in both arms; where
/// an arm is given more of them than it has stiffness, its stiffness goes to them in proportion. Without one, no wire
/// ends in the joint: stiffness passes as [`share_out`] has it, and what an arm has beyond it goes with the wires that
/// it passes on, in proportion.
pub fn shared(spec: &JointSpec) -> Shared {
    let k = spec.arms.len();
    let arms = Stiff::of(&spec.arms);
    let own: Vec<Vector> = arms.iter().map(|arm| arm.stiffness).collect();
    let mut table = vec![vec![Vector::zeros(); k]; k];
    let mut notes = Vec::new();
    let row = |row: &[Vector]| row.iter().sum::<Vector>();
    if spec.wires.is_empty() {
        for i in 0..3 {
            let (passed, surplus) = share_out(&own.iter().map(|c| c[i]).collect::<Vec<_>>());
            for (row, passed) in table.iter_mut().zip(passed) {
                row.iter_mut().zip(passed).for_each(|(to, x)| to[i] = x);
            }
            if i == 0
                && k > 2
                && let Some(a) = (0..k).find(|&a| surplus[a] > NOTED_SHARE * own[a][0])
            {
                notes.push(format!(
                    "arm `{}` is {:.0} % stiffer in bending than all other arms of joint `{}` together; all its wires \
                     are taken to \
                     run on, for nothing is said of them (`wires`)",
                    spec.arms[a].branch,
                    100.0 * surplus[a] / (own[a][0] - surplus[a]),
                    spec.name
                ));
            }
        }
        for (own, all) in own.iter().zip(&mut table) {
            let passed = row(all);
            all.iter_mut().for_each(|x| *x = x.component_mul(&own.component_div(&passed)));
        }
        return Shared { arms, table, notes };
    }
    for wire in &spec.wires {
        let x = own[wire.from] * wire.fraction;
        table[wire.from][wire.to] += x;
        table[wire.to][wire.from] += x;
    }
    for ((arm, own), all) in spec.arms.iter().zip(&own).zip(&mut table) {
        let passed = row(all);
        let ending = 1.0 - passed[0] / own[0];
        if ending > NOTED_SHARE {
            notes.push(format!(
                "{:.0} % of the bending stiffness of arm `{}` ends in joint `{}`: no other arm takes it up",
                100.0 * ending,
                arm.branch,
                spec.name
            ));
        }
        let least = own.zip_map(&passed, |own, passed| if passed > own { own / passed } else { 1.0 });
        all.iter_mut().for_each(|x| *x = x.component_mul(&least));
    }
    Shared { arms, table, notes }
}

/// The symmetric table X with zero diagonal whose rows add up to `stiffness` (one entry for each arm, all
/// positive), and for each arm what is left over.
///
/// If one arm outweighs all others together there is no such table: its surplus is left over uncoupled. Otherwise X =
/// diag(u) (1 − I) diag(u), the limit of proportional fitting (Deming and Stephan 1940, in the symmetric form of
/// Sinkhorn and Knopp 1967): of all tables with these sums the one nearest to "everyone with everyone in proportion".
/// Its rows add up where `u_a (U − u_a) = s_a` with `U = Σ u`: `u_a = ½ (U ∓ √(U² − 4 s_a))`, the upper sign but
/// perhaps for the stiffest arm, which leaves one equation for U.
pub fn share_out(stiffness: &[f64]) -> (Vec<Vec<f64>>, Vec<f64>) {
    let k = stiffness.len();
    let total: f64 = stiffness.iter().sum();
    let mut surplus = vec![0.0; k];
    let stiffest = (0..k).max_by(|&a, &b| stiffness[a].total_cmp(&stiffness[b])).unwrap_or(0);
    let others = total - stiffness[stiffest];
    if stiffness[stiffest] >= others {
        surplus[stiffest] = stiffness[stiffest] - others;
        // Every other arm then passes all it has to this one.
        let mut table = vec![vec![0.0; k]; k];
        for b in (0..k).filter(|&b| b != stiffest) {
            table[stiffest][b] = stiffness[b];
            table[b][stiffest] = stiffness[b];
        }
        return (table, surplus);
    }
    // The smaller root without cancellation, and its partner.
    let smaller = |u: f64, s: f64| 2.0 * s / (u + (u * u - 4.0 * s).max(0.0).sqrt());
    let least = 2.0 * stiffness[stiffest].sqrt();
    let sum_of = |u: f64, upper: bool| -> f64 {
        let all: f64 = stiffness.iter().map(|&s| smaller(u, s)).sum();
        let stiff = smaller(u, stiffness[stiffest]);
        if upper { all - stiff + (u - stiff) } else { all }
    };
    let upper = sum_of(least, false) < least;
    // The sum is above U on one side of the root and below it on the other.
    let (mut low, mut high) = (least, 2.0 * least);
    while (sum_of(high, upper) < high) == (sum_of(low, upper) < low) && high < 1e12 * least {
        high *= 2.0;
    }
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if (sum_of(middle, upper) < middle) == (sum_of(low, upper) < low) {
            low = middle;
        } else {
            high = middle;
        }
    }
    let mut u: Vec<f64> = stiffness.iter().map(|&s| smaller(low, s)).collect();
    if upper {
        u[stiffest] = low - u[stiffest];
    }
    let table = (0..k).map(|a| (0..k).map(|b| if a == b { 0.0 } else { u[a] * u[b] }).collect()).collect();
    (table, surplus)
}

#[cfg(test)]
mod tests {
    use super::{share_out, shared};
    use wireloom_core::joint::{JointSpec, WireShare};
    use wireloom_core::{Arm, ArmSpring, Rotation, Section, Vector};

    fn spec(stiffness: &[f64], wires: &[(usize, usize, f64)]) -> JointSpec {
        let section = |x: f64| Section {
            name: "s".into(),
            diameter: 0.008,
            linear_density: 0.1,
            axial_stiffness: 1e4,
            shear_stiffness: [4e3; 2],
            bending_stiffness: [x, 2.0 * x],
            torsion_stiffness: 0.7 * x,
            coupling_stiffness: [0.0; 3],
            min_bend_radius: None,
            min_bend_radius_moving: None,
            max_tension: None,
            max_torsion: None,
            thermal_expansion: 0.0,
            thermal_curvature: Vector::zeros(),
            friction: Default::default(),
            set: None,
            laws: Default::default(),
        };
        let arm = |x: &f64| Arm {
            branch: "arm".into(),
            starts_here: true,
            rest: Rotation::identity(),
            offset: Vector::zeros(),
            section: section(*x),
            segment_length: 0.01,
            length: 0.5,
            curvature: Vector::zeros(),
            spring: ArmSpring::default(),
        };
        let wires = wires.iter().map(|&(from, to, fraction)| WireShare { from, to, fraction });
        JointSpec { name: "joint".into(), arms: stiffness.iter().map(arm).collect(), wires: wires.collect() }
    }

    /// Fractions of the EI1, EI2 and GJ of each arm that belong to its wires to the other arms.
    fn used(spec: &JointSpec) -> Vec<Vector> {
        let table = shared(spec).table;
        let used = spec.arms.iter().zip(&table);
        used.map(|(arm, row)| row.iter().sum::<Vector>().component_div(&arm.section.bend_diagonal())).collect()
    }

    #[test]
    fn where_nothing_is_said_no_wire_ends() {
        for stiffness in [vec![1.0, 1.0], vec![1.0, 0.2], vec![3.0, 2.0, 2.0], vec![5.0, 1.0, 1.0], vec![1.0; 16]] {
            let spec = spec(&stiffness, &[]);
            for part in used(&spec) {
                assert!((part - Vector::repeat(1.0)).amax() < 1e-9, "{stiffness:?}: {part}");
            }
            assert_eq!(shared(&spec).notes.len(), usize::from(stiffness[0] == 5.0), "{stiffness:?}");
        }
    }

    #[test]
    fn wires_are_never_stiffer_than_the_arm_they_are_part_of() {
        // 0.9 of the first arm's stiffness is more than the second one has, 0.1 of it less than the third one has.
        let spec = spec(&[2.0, 1.0, 1.0], &[(0, 1, 0.9), (0, 2, 0.1)]);
        let want = [1.0, 1.0, 0.2];
        for (part, want) in used(&spec).iter().zip(want) {
            assert!((part - Vector::repeat(want)).amax() < 1e-12, "{part} instead of {want}");
        }
        assert!(shared(&spec).notes.iter().any(|note| note.contains("80 % of the bending stiffness")));
    }

    fn rows(table: &[Vec<f64>]) -> Vec<f64> {
        table.iter().map(|row| row.iter().sum()).collect()
    }

    #[test]
    fn two_equal_arms_pass_everything() {
        let (table, surplus) = share_out(&[0.02, 0.02]);
        assert_eq!(table, vec![vec![0.0, 0.02], vec![0.02, 0.0]]);
        assert_eq!(surplus, vec![0.0, 0.0]);
    }

    #[test]
    fn three_arms_have_the_one_solution() {
        // x12 + x13 = 4, x12 + x23 = 3, x13 + x23 = 2: x12 = 2.5, x13 = 1.5, x23 = 0.5.
        let (table, _) = share_out(&[4.0, 3.0, 2.0]);
        for (got, want) in [(table[0][1], 2.5), (table[0][2], 1.5), (table[1][2], 0.5)] {
            assert!((got - want).abs() < 1e-10, "{got} instead of {want}");
        }
    }

    #[test]
    fn rows_add_up_for_many_arms_and_wide_ratios() {
        for stiffness in [vec![1.0; 16], vec![1.0, 2.0, 3.0, 4.0, 9.0], vec![1e-4, 1.0, 1.00005, 3e-4]] {
            let (table, surplus) = share_out(&stiffness);
            for ((row, s), left) in rows(&table).iter().zip(&stiffness).zip(&surplus) {
                assert!((row + left - s).abs() <= 1e-6 * s, "{row} + {left} instead of {s}");
            }
        }
    }

    #[test]
    fn an_arm_that_outweighs_all_others_keeps_its_surplus() {
        let (table, surplus) = share_out(&[10.0, 1.0, 2.0]);
        assert_eq!(surplus, vec![7.0, 0.0, 0.0]);
        assert_eq!(rows(&table), vec![3.0, 1.0, 2.0]);
        assert_eq!(table[1][2], 0.0);
    }
}

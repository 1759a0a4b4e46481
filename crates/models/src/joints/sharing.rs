//! How much stiffness passes between the arms of a joint when nothing is said about its wires.

/// The symmetric table X with zero diagonal whose rows add up to `stiffness` (one entry for each arm, all
/// positive), and for each arm what is left over.
///
/// Where one arm outweighs all others together there is no such table: its surplus is left over
/// uncoupled. Otherwise X = diag(u) (1 − I) diag(u), the limit of proportional fitting (Deming and Stephan 1940, in the
/// symmetric form of Sinkhorn and Knopp 1967): of all tables with these sums the one nearest to "everyone with everyone in
/// proportion". Its rows add up where `u_a (U − u_a) = s_a` with `U = Σ u`: `u_a = ½ (U ∓ √(U² − 4 s_a))`, the upper sign but
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
    use super::share_out;

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

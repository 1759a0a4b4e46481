//! Whether one of two programs is faster, from times that were measured in pairs.
//!
//! Each pair gives x = ln(t_B / t_A). If the programs are equally fast, x and −x are equally likely, because the order
//! within the pairs alternates. Then the signed-rank statistic of Wilcoxon (1945) has a known distribution, whatever
//! the distribution of the times; single outliers do little. The interval has the ratios that this test does not
//! reject: order statistics of the Walsh averages (x_i + x_j)/2, i ≤ j. Their median is the estimate of Hodges and
//! Lehmann (1963). See Hollander, Wolfe and Chicken, Nonparametric Statistical Methods (2014), sections 3.1 to 3.3.

/// Probability that a comparison of two equally fast programs calls any of its cases faster or slower.
pub const ERROR: f64 = 0.05;

/// What the times of one case tell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// Estimate of t_B / t_A.
    pub ratio: f64,
    /// Interval of t_B / t_A. All cases are in theirs with a probability of at least 1 − [`ERROR`].
    pub interval: [f64; 2],
}

/// Verdict on program B.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    Faster,
    Slower,
    CannotTell,
}

impl Comparison {
    /// Compares times of A and B (s, positive), one of `cases` comparisons that are made together: each of them may err
    /// with a probability of [`ERROR`] / `cases` (Bonferroni).
    pub fn new(pairs: &[[f64; 2]], cases: usize) -> Self {
        let x: Vec<f64> = pairs.iter().map(|[a, b]| (b / a).ln()).collect();
        let mut walsh: Vec<f64> =
            (0..x.len()).flat_map(|i| x[..=i].iter().map(move |&y| (y, i))).map(|(y, i)| 0.5 * (x[i] + y)).collect();
        walsh.sort_by(f64::total_cmp);
        let all = walsh.len();
        let ratio = (0.5 * (walsh[(all - 1) / 2] + walsh[all / 2])).exp();
        let interval = match most_rejected(x.len(), 0.5 * ERROR / cases as f64) {
            Some(most) => [walsh[most].exp(), walsh[all - 1 - most].exp()],
            None => [0.0, f64::INFINITY],
        };
        Self { ratio, interval }
    }

    /// Whether B is faster or slower than A.
    pub fn verdict(&self) -> Verdict {
        match self.interval {
            [_, high] if high < 1.0 => Verdict::Faster,
            [low, _] if low > 1.0 => Verdict::Slower,
            _ => Verdict::CannotTell,
        }
    }
}

impl Verdict {
    pub fn words(self) -> &'static str {
        match self {
            Verdict::Faster => "faster",
            Verdict::Slower => "slower",
            Verdict::CannotTell => "cannot tell",
        }
    }
}

/// The smallest number of pairs with which so many cases can be told apart.
pub fn least_pairs(cases: usize) -> usize {
    (1..).find(|&n| most_rejected(n, 0.5 * ERROR / cases as f64).is_some()).expect("2⁻ⁿ falls below any number")
}

/// The largest c with P(T ≤ c) ≤ `tail`, where T is the signed-rank statistic of `n` pairs: the sum of a random subset
/// of 1, 2, …, n.
fn most_rejected(n: usize, tail: f64) -> Option<usize> {
    // probability[t] = P(T = t), one rank after the other.
    let mut probability = vec![1.0];
    for rank in 1..=n {
        let mut next = vec![0.0; probability.len() + rank];
        for (t, p) in probability.iter().enumerate() {
            next[t] += 0.5 * p;
            next[t + rank] += 0.5 * p;
        }
        probability = next;
    }
    let mut sum = 0.0;
    let within = probability.iter().take_while(|p| {
        sum += **p;
        sum <= tail
    });
    within.count().checked_sub(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Critical values of the two-sided test at 5 % and at 1 %, from the usual tables.
    #[test]
    fn the_critical_values_are_those_of_the_tables() {
        for (n, five, one) in [
            (6, Some(0), None),
            (8, Some(3), Some(0)),
            (10, Some(8), Some(3)),
            (12, Some(13), Some(7)),
            (20, Some(52), Some(37)),
        ] {
            assert_eq!((most_rejected(n, 0.025), most_rejected(n, 0.005)), (five, one), "{n} pairs");
        }
        assert_eq!((least_pairs(1), least_pairs(20), least_pairs(100)), (6, 10, 12));
    }

    /// Normal numbers from a linear congruential generator (Knuth) and the method of Box and Muller.
    struct Random(u64);

    impl Random {
        fn uniform(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((self.0 >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
        }
        fn normal(&mut self) -> f64 {
            (-2.0 * self.uniform().ln()).sqrt() * (2.0 * std::f64::consts::PI * self.uniform()).cos()
        }
    }

    /// Twelve pairs on a machine that slows down by a third from the first to the last, scatters by 5 %, and does
    /// something else at times; B takes `ratio` times as long as A.
    fn measured(random: &mut Random, ratio: f64) -> Vec<[f64; 2]> {
        let pair = |k: usize| {
            let mut time = |first: bool, factor: f64| {
                let drift = 1.0 + 0.03 * (k as f64 + if first { 0.0 } else { 0.5 });
                let other = if random.uniform() < 0.1 { 2.0 } else { 1.0 };
                1e-3 * factor * drift * other * (0.05 * random.normal()).exp()
            };
            match k % 2 {
                0 => [time(true, 1.0), time(false, ratio)],
                _ => {
                    let b = time(true, ratio);
                    [time(false, 1.0), b]
                }
            }
        };
        (0..12).map(pair).collect()
    }

    #[test]
    fn equal_programs_are_told_apart_no_more_often_than_promised() {
        let (mut random, mut missed) = (Random(1), [0, 0]);
        for _ in 0..4_000 {
            let pairs = measured(&mut random, 1.0);
            for (missed, cases) in missed.iter_mut().zip([1, 20]) {
                *missed += usize::from(Comparison::new(&pairs, cases).verdict() != Verdict::CannotTell);
            }
        }
        // 5 % and 0.25 %, and three standard deviations of such a count.
        assert!(missed[0] < 200 + 42 && missed[1] < 10 + 10, "{missed:?} of 4,000");
    }

    #[test]
    fn a_slower_program_is_found_and_its_ratio_lies_in_the_interval() {
        let (mut random, mut found, mut inside) = (Random(2), 0, 0);
        for _ in 0..1_000 {
            let slower = Comparison::new(&measured(&mut random, 1.4), 1);
            found += usize::from(slower.verdict() == Verdict::Slower);
            inside += usize::from(slower.interval[0] <= 1.4 && 1.4 <= slower.interval[1]);
        }
        assert!(found > 750 && inside > 930, "{found} found, {inside} inside of 1,000");
    }

    #[test]
    fn both_directions_and_exact_times() {
        let pairs = |ratio: f64| vec![[2.0, 2.0 * ratio]; 12];
        let of = |ratio: f64| Comparison::new(&pairs(ratio), 10);
        assert_eq!(of(0.5).verdict(), Verdict::Faster);
        assert_eq!(of(2.0).verdict(), Verdict::Slower);
        assert_eq!(of(1.0), Comparison { ratio: 1.0, interval: [1.0, 1.0] });
        assert_eq!(of(1.0).verdict(), Verdict::CannotTell);
        // Too few pairs for any verdict.
        assert_eq!(Comparison::new(&pairs(2.0)[..5], 10).verdict(), Verdict::CannotTell);
    }
}

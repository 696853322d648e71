//! Axes of a plot: from a value to a place between 0 and 1, and the ticks.

/// How many decades an axis labels one by one.
const DECADES: i32 = 6;

/// An axis.
#[derive(Debug, Clone)]
pub struct Axis {
    /// Value at the lower end.
    pub low: f64,
    /// Value at the upper end.
    pub high: f64,
    is_log: bool,
    /// Power of ten that the labels leave out, where there is one.
    pub power: Option<String>,
    /// Values that are labelled.
    pub ticks: Vec<(f64, String)>,
}

impl Axis {
    /// Just around the values; about `wanted` ticks at round values within.
    pub fn tight(values: impl Iterator<Item = f64>, wanted: usize, in_degrees: bool) -> Self {
        let (low, high) = span(values);
        let step = match in_degrees && high - low >= 60.0 {
            true => round_angle((high - low) / wanted as f64),
            false => round_step((high - low) / wanted as f64),
        };
        let first = (low / step - 1e-9).ceil() as i64;
        let last = (high / step + 1e-9).floor() as i64;
        Self::with_ticks(low, high, first, last, step)
    }

    /// From one round value to another, with the values between.
    pub fn round(values: impl Iterator<Item = f64>, wanted: usize) -> Self {
        let (low, high) = span(values);
        let step = round_step((high - low) / wanted as f64);
        let first = (low / step + 1e-9).floor() as i64;
        let last = (high / step - 1e-9).ceil() as i64;
        Self::with_ticks(first as f64 * step, last as f64 * step, first, last, step)
    }

    fn with_ticks(low: f64, high: f64, first: i64, last: i64, step: f64) -> Self {
        let largest = low.abs().max(high.abs());
        let exponent = match (1e-3..1e5).contains(&largest) {
            true => 0,
            false => largest.log10().floor() as i32,
        };
        let unit = 10f64.powi(exponent);
        let ticks = (first..=last).map(|i| i as f64 * step);
        Self {
            low,
            high,
            is_log: false,
            power: (exponent != 0).then(|| power_of_ten(exponent)),
            ticks: ticks
                .map(|value| (value, decimal(value / unit, step / unit)))
                .collect(),
        }
    }

    /// Whole decades around the positive values.
    pub fn log(values: impl Iterator<Item = f64>) -> Self {
        let positive = values.filter(|value| *value > 0.0).map(f64::log10);
        let (low, high) = positive.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
            (low.min(x), high.max(x))
        });
        let (low, high) = match low <= high {
            true => (low, high),
            false => (0.0, 1.0),
        };
        let first = (low + 1e-9).floor() as i32;
        let last = ((high - 1e-9).ceil() as i32).max(first + 1);
        let every = ((last - first + DECADES - 1) / DECADES).max(1);
        let ticks = (first..=last).filter(|exponent| (last - exponent) % every == 0);
        Self {
            low: 10f64.powi(first),
            high: 10f64.powi(last),
            is_log: true,
            power: None,
            ticks: ticks
                .map(|exponent| (10f64.powi(exponent), power_of_ten(exponent)))
                .collect(),
        }
    }

    /// Place of a value: 0 at the lower end, 1 at the upper one; `None` where it has none.
    pub fn at(&self, value: f64) -> Option<f64> {
        let place = match self.is_log {
            true => (value / self.low).log10() / (self.high / self.low).log10(),
            false => (value - self.low) / (self.high - self.low),
        };
        place.is_finite().then_some(place)
    }
}

/// Smallest and largest value; something around them where they are one, or none.
fn span(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let ends = values.fold(None, |ends: Option<(f64, f64)>, x| {
        Some(ends.map_or((x, x), |(low, high)| (low.min(x), high.max(x))))
    });
    match ends {
        None => (0.0, 1.0),
        Some((low, high)) if high - low > 1e-12 * low.abs().max(high.abs()) => (low, high),
        Some((0.0, _)) => (-1.0, 1.0),
        Some((value, _)) => (value - 0.1 * value.abs(), value + 0.1 * value.abs()),
    }
}

/// The least of 1, 2, 5 times a power of ten that is not below `least`.
fn round_step(least: f64) -> f64 {
    let power = 10f64.powf(least.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|digit| digit * power);
    let fits = |step: &f64| *step >= least * (1.0 - 1e-9);
    steps.into_iter().find(fits).unwrap_or(10.0 * power)
}

/// Ticks of an axis of degrees.
fn round_angle(least: f64) -> f64 {
    let steps = [15.0, 30.0, 45.0, 60.0, 90.0, 180.0, 360.0, 720.0];
    let fits = |step: &f64| *step >= least;
    steps
        .into_iter()
        .find(fits)
        .unwrap_or_else(|| round_step(least))
}

fn decimal(value: f64, step: f64) -> String {
    let decimals = (-(step * 1.000_001).log10().floor()).clamp(0.0, 9.0) as usize;
    // The minus sign that is as wide as a digit.
    format!("{:.decimals$}", value + 0.0).replace('-', "\u{2212}")
}

/// As in 10⁻⁵.
fn power_of_ten(exponent: i32) -> String {
    let raised = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => char::from_u32('⁰' as u32 + digit as u32 - '0' as u32).unwrap_or(digit),
    };
    match exponent {
        0 => "1".to_owned(),
        1 => "10".to_owned(),
        _ => format!(
            "10{}",
            exponent.to_string().chars().map(raised).collect::<String>()
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis) -> Vec<&str> {
        axis.ticks.iter().map(|(_, label)| label.as_str()).collect()
    }

    #[test]
    fn ticks_are_round_values_in_the_range() {
        let azimuth = Axis::tight([0.0, 350.0].into_iter(), 5, true);
        assert_eq!(labels(&azimuth), ["0", "90", "180", "270"]);
        assert_eq!(azimuth.high, 350.0);
        let angle = Axis::round([-9.8, 9.8].into_iter(), 5);
        assert_eq!(labels(&angle), ["\u{2212}10", "\u{2212}5", "0", "5", "10"]);
        let small = Axis::round([0.0, 3.2e-5].into_iter(), 4);
        assert_eq!(labels(&small), ["0", "1", "2", "3", "4"]);
        assert_eq!(small.power.as_deref(), Some("10⁻⁵"));
        let fine = Axis::round([0.52, 0.61].into_iter(), 5);
        assert_eq!(labels(&fine)[..2], ["0.52", "0.54"]);
    }

    #[test]
    fn a_logarithmic_axis_has_whole_decades() {
        let axis = Axis::log([0.0, 3e-5, 0.2].into_iter());
        assert_eq!(labels(&axis), ["10⁻⁵", "10⁻⁴", "10⁻³", "10⁻²", "10⁻¹", "1"]);
        let half = axis.at(10f64.powf(-2.5)).expect("it is positive");
        assert!((half - 0.5).abs() < 1e-12);
        assert_eq!(axis.at(0.0), None);
        assert!(Axis::log([1e-17, 1e-3].into_iter()).ticks.len() <= 8);
    }

    #[test]
    fn one_value_has_an_axis_around_it() {
        for value in [0.0, 5.0, -3e-9] {
            let axis = Axis::round([value; 3].into_iter(), 5);
            assert!(axis.low < value && value < axis.high, "{axis:?}");
        }
        assert!(Axis::round(std::iter::empty(), 5).ticks.len() > 1);
    }
}

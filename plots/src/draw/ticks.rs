//! Ticks, their labels, and prefixes of units.

use crate::svg::text::superscript;

/// A factor from values to the numbers on an axis, with the unit of these numbers.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Scale {
    pub(crate) factor: f64,
    pub(crate) unit: String,
}

/// Units that take a prefix.
const PREFIXED: [&str; 11] = ["m", "N", "s", "rad", "Hz", "N m", "m/s", "m/s²", "W", "J", "Pa"];

/// The scale on which `largest` has between one and four digits before the point.
pub(crate) fn scale(unit: &str, largest: f64) -> Scale {
    let plain = Scale { factor: 1.0, unit: unit.to_owned() };
    let least = if unit == "m" || unit == "s" { 1.0 } else { 0.1 };
    if largest == 0.0 || (least..1e4).contains(&largest) || !largest.is_finite() {
        return plain;
    }
    let power = 3 * (largest.log10() / 3.0).floor() as i32;
    let prefix = match power {
        -9 => "n",
        -6 => "μ",
        -3 => "m",
        3 => "k",
        6 => "M",
        9 => "G",
        _ => "",
    };
    let factor = 10f64.powi(-power);
    if PREFIXED.contains(&unit) && !prefix.is_empty() {
        return Scale { factor, unit: format!("{prefix}{unit}") };
    }
    if (0.01..1e4).contains(&largest) {
        return plain;
    }
    let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
    Scale { factor, unit: format!("10{}{unit}", superscript(power)) }
}

/// A tick: value on the axis and label; minor ticks have none.
pub(crate) type Tick = (f64, Option<String>);

/// Ticks at multiples of 1, 2, 2.5 or 5 times a power of ten, about `count` of them.
pub(crate) fn linear([low, high]: [f64; 2], count: f64) -> Vec<Tick> {
    let rough = (high - low) / count.max(1.0);
    let power = rough.log10().floor();
    let base = 10f64.powf(power);
    let step = [1.0, 2.0, 2.5, 5.0, 10.0].map(|m| m * base).into_iter().find(|s| *s >= rough * 0.999);
    let step = step.unwrap_or(10.0 * base);
    let is_whole = |decimals: &i32| {
        let digits = step * 10f64.powi(*decimals);
        (digits - digits.round()).abs() < 1e-6 * digits
    };
    let decimals = (0..16).find(is_whole).unwrap_or(16) as usize;
    let slack = 1e-9 * (high - low);
    let (first, last) = (((low - slack) / step).ceil() as i64, ((high + slack) / step).floor() as i64);
    (first..=last)
        .map(|k| {
            let value = k as f64 * step;
            (value, Some(minus(format!("{value:.decimals$}"), k == 0)))
        })
        .collect()
}

/// A number with a minus sign in the place of the hyphen.
fn minus(text: String, zero: bool) -> String {
    if zero { text.trim_start_matches('-').to_owned() } else { text.replace('-', "−") }
}

/// Ticks at powers of ten, with minor ticks at their multiples. Labels stand at all of these or at 1, 2 and 5 if `count` of
/// them suffice. Numbers from 0.0001 to a million are written out.
pub(crate) fn logarithmic([low, high]: [f64; 2], count: f64) -> Vec<Tick> {
    let (first, last) = (low.log10().floor() as i32, high.log10().ceil() as i32);
    let decades = (high / low).log10();
    let every = (decades / count.max(1.0)).ceil().max(1.0) as i32;
    let (all, few) = (9.0 * decades <= 1.2 * count, 3.0 * decades <= 1.2 * count);
    let plain = low >= 1e-4 && high < 1e6;
    let mut ticks = Vec::new();
    for power in first..=last {
        for digit in 1..10 {
            let value = f64::from(digit) * 10f64.powi(power);
            if value < low * (1.0 - 1e-9) || value > high * (1.0 + 1e-9) {
                continue;
            }
            let is_named = match digit {
                1 => power.rem_euclid(every) == 0,
                2 | 5 => all || few,
                _ => all,
            };
            let label = is_named.then(|| match digit {
                _ if plain => format!("{}", (value * 1e4).round() / 1e4),
                1 => format!("10{}", superscript(power)),
                _ => format!("{digit}·10{}", superscript(power)),
            });
            if label.is_some() || every == 1 {
                ticks.push((value, label));
            }
        }
    }
    ticks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_numbers() {
        let labels = |range, count| linear(range, count).into_iter().filter_map(|t| t.1).collect::<Vec<_>>();
        assert_eq!(labels([-0.3, 1.0], 4.0), ["0.0", "0.5", "1.0"]);
        assert_eq!(labels([-20.0, 20.0], 4.0), ["−20", "−10", "0", "10", "20"]);
        let decades = logarithmic([1e-8, 1e-5], 4.0);
        assert_eq!(decades.iter().filter(|t| t.1.is_some()).count(), 4);
        assert_eq!(decades[0].1.as_deref(), Some("10⁻⁸"));
    }

    #[test]
    fn units_take_prefixes() {
        assert_eq!(scale("m", 4.2e-5), Scale { factor: 1e6, unit: "μm".into() }.rounded());
        assert_eq!(scale("N/m", 3e8).unit, "10⁶ N/m");
        assert_eq!(scale("1", 3e-5).unit, "10⁻⁶");
        assert_eq!(scale("rad/s", 250.0).unit, "rad/s");
    }

    impl Scale {
        fn rounded(self) -> Self {
            Scale { factor: 10f64.powi(6), ..self }
        }
    }
}

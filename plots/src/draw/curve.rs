//! Curves and markers in points of the picture.

use crate::draw::colours::{Ink, Theme};
use crate::draw::layers::{Curve, Mark, dash};
use crate::svg::writer::{Stroke, Svg, number, path};
use std::collections::HashSet;
use std::fmt::Write;

/// Distance from the curve up to which points are left out.
const TOLERANCE: f64 = 0.04;

/// The points of a curve along x that show: of many in one half point of the width, the first, lowest, highest and last.
fn thinned(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    if !points.is_sorted_by(|a, b| a[0] <= b[0]) {
        return points.to_vec();
    }
    let mut kept = Vec::new();
    for column in points.chunk_by(|a, b| (2.0 * a[0]).floor() == (2.0 * b[0]).floor()) {
        let extreme = |sign: f64| {
            (0..column.len()).max_by(|i, j| (sign * column[*i][1]).total_cmp(&(sign * column[*j][1])))
        };
        let mut ends = [Some(0), extreme(1.0), extreme(-1.0), Some(column.len() - 1)];
        ends.sort_unstable();
        kept.extend(ends.into_iter().flatten().map(|i| column[i]));
    }
    kept
}

/// The points that keep a polyline within `TOLERANCE`.   Source: Douglas and Peucker 1973.
pub(crate) fn simplified(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut keep = vec![false; points.len()];
    let Some(last) = points.len().checked_sub(1) else { return Vec::new() };
    (keep[0], keep[last]) = (true, true);
    let mut spans = vec![[0, last]];
    while let Some([from, to]) = spans.pop() {
        let ([ax, ay], [bx, by]) = (points[from], points[to]);
        let (dx, dy) = (bx - ax, by - ay);
        let square = dx * dx + dy * dy;
        let off = |[x, y]: [f64; 2]| {
            let along = if square > 0.0 { ((x - ax) * dx + (y - ay) * dy) / square } else { 0.0 };
            let along = along.clamp(0.0, 1.0);
            (x - ax - along * dx).hypot(y - ay - along * dy)
        };
        let farthest = (from + 1..to).map(|i| (off(points[i]), i)).max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((distance, i)) = farthest
            && distance > TOLERANCE
        {
            keep[i] = true;
            spans.extend([[from, i], [i, to]]);
        }
    }
    points.iter().zip(keep).filter(|(_, keep)| *keep).map(|(point, _)| *point).collect()
}

/// The outline of a marker: circle, square, triangle, diamond, triangle down, hexagon.
pub(crate) fn marker([x, y]: [f64; 2], style: usize, size: f64) -> String {
    let corners = |count: usize, turn: f64, size: f64| {
        let at = |k: usize| {
            let (sin, cos) = (turn + std::f64::consts::TAU * k as f64 / count as f64).sin_cos();
            [x + size * cos, y + size * sin]
        };
        path(&(0..count).map(at).collect::<Vec<_>>(), true)
    };
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};
    match style % 6 {
        0 => {
            let r = number(size);
            let (left, d) = (number(x - size), number(2.0 * size));
            format!("M{left} {}a{r} {r} 0 1 0 {d} 0a{r} {r} 0 1 0 -{d} 0Z", number(y))
        }
        1 => corners(4, FRAC_PI_4, 1.25 * size),
        2 => corners(3, -FRAC_PI_2, 1.35 * size),
        3 => corners(4, 0.0, 1.35 * size),
        4 => corners(3, FRAC_PI_2, 1.35 * size),
        _ => corners(6, 0.0, 1.1 * size),
    }
}

/// Size of an open marker.
pub(crate) const RING: f64 = 4.4;

/// Heads of arrows at a sixth, a half and five sixths of a polyline; of a straight line at its end.
fn heads(points: &[[f64; 2]]) -> String {
    if let [[ax, ay], [bx, by]] = *points {
        let turn = (by - ay).atan2(bx - ax);
        return head([bx - TIP * turn.cos(), by - TIP * turn.sin()], turn);
    }
    let length = |two: &[[f64; 2]]| (two[1][0] - two[0][0]).hypot(two[1][1] - two[0][1]);
    let whole: f64 = points.windows(2).map(length).sum();
    let mut d = String::new();
    let mut passed = 0.0;
    for two in points.windows(2) {
        let [before, after] = [passed, passed + length(two)];
        passed = after;
        for share in [1.0 / 6.0, 0.5, 5.0 / 6.0] {
            if (before..after).contains(&(share * whole)) {
                let [dx, dy] = [two[1][0] - two[0][0], two[1][1] - two[0][1]];
                let (turn, part) = (dy.atan2(dx), (share * whole - before) / (after - before));
                let [x, y] = [two[0][0] + part * dx, two[0][1] + part * dy];
                d += &head([x, y], turn);
            }
        }
    }
    d
}

/// Distance of the tip of an arrow head from its point.
const TIP: f64 = 6.5;

/// The head of an arrow at a point, towards an angle.
pub(crate) fn head([x, y]: [f64; 2], turn: f64) -> String {
    let corner = |angle: f64, size: f64| [x + size * (turn + angle).cos(), y + size * (turn + angle).sin()];
    path(&[corner(0.0, TIP), corner(2.5, 5.5), corner(-2.5, 5.5)], true)
}

/// Draws a curve through points of the picture. `foot`: where bars start. `cased`: over a map.
pub(crate) fn draw(svg: &mut Svg, theme: Theme, curve: &Curve, points: &[[f64; 2]], foot: f64, cased: bool) {
    let colour = theme.colour(curve.ink);
    let dash = if curve.mark == Mark::Directed { "" } else { dash(curve.style) };
    let stroke = |width: f64| Stroke { colour: &colour, width, dash };
    match curve.mark {
        Mark::Line | Mark::Dashed | Mark::Directed => {
            let d = path(&simplified(&thinned(points)), false);
            if cased {
                svg.stroke(&d, Stroke { colour: "#ffffff", width: curve.width + 2.2, dash: "" });
                svg.stroke(&d, Stroke { colour: "#000000", ..stroke(curve.width) });
            } else {
                svg.stroke(&d, stroke(curve.width));
            }
            if curve.mark == Mark::Directed {
                svg.fill(&heads(points), &colour, 1.0);
            }
        }
        Mark::Rings => {
            let all: String = points.iter().map(|p| marker(*p, curve.style, RING)).collect();
            svg.stroke(&all, Stroke { dash: "", ..stroke(1.3) });
        }
        Mark::Dots | Mark::Joined => {
            if curve.mark == Mark::Joined {
                svg.stroke(&path(points, false), Stroke { dash: "", ..stroke(curve.width) });
            }
            let size = if points.len() > 60 { 2.2 } else { 3.0 };
            let rim = theme.colour(Ink::Paper);
            let all = |size: f64| points.iter().map(|p| marker(*p, curve.style, size)).collect::<String>();
            svg.fill(&all(size + 0.7), &rim, 1.0);
            svg.fill(&all(size), if cased { "#000000" } else { &colour }, 1.0);
        }
        Mark::Specks => {
            let mut seen = HashSet::new();
            let mut d = String::new();
            for [x, y] in points {
                if seen.insert(((x * 4.0).round() as i64, (y * 4.0).round() as i64)) {
                    let _ = write!(d, "M{} {}h0", number(*x), number(*y));
                }
            }
            if cased {
                svg.specks(&d, "#ffffff", curve.width + 1.6);
                svg.specks(&d, "#000000", curve.width);
            } else {
                svg.specks(&d, &colour, curve.width);
            }
        }
        Mark::Bars => {
            let mut d = String::new();
            for [x, y] in points {
                let _ = write!(d, "M{} {}V{}", number(*x), number(foot), number(*y));
            }
            svg.stroke(&d, stroke(curve.width));
        }
        Mark::Area => svg.fill(&path(&simplified(points), true), &colour, 0.28),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_points_keep_their_extremes() {
        let swing = |i: u32| [1e-4 * f64::from(i), 50.0 * f64::from(i).sin()];
        let points: Vec<_> = (0..100_000).map(swing).collect();
        let few = thinned(&points);
        let highest = |points: &[[f64; 2]]| points.iter().fold(0.0f64, |m, p| m.max(p[1]));
        assert!(few.len() <= 80 && highest(&few) == highest(&points));
    }

    #[test]
    fn simplified_curves_stay_on_their_points() {
        let at = |i: usize| [0.1 * i as f64, 40.0 * (0.02 * i as f64).sin()];
        let points: Vec<_> = (0..3000).map(at).collect();
        let few = simplified(&points);
        assert!(few.len() < 600);
        let off = |[x, y]: [f64; 2]| {
            few.windows(2).fold(f64::INFINITY, |least, two| {
                if x < two[0][0] || x > two[1][0] {
                    return least;
                }
                let along = (x - two[0][0]) / (two[1][0] - two[0][0]);
                // Slopes are at most 8: the distance along y is at most nine times that across.
                least.min((y - two[0][1] - along * (two[1][1] - two[0][1])).abs() / 9.0)
            })
        };
        assert!(points.iter().all(|p| off(*p) <= TOLERANCE));
    }
}

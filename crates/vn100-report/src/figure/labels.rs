//! Labels keep clear of what is drawn: of lines, symbols and other labels.

use super::drawing::{Anchor, At, LETTERS, Primitive, Rectangle, Shape};

/// Letters are as high as this share of their size above their baseline, and reach below it.
const ABOVE: f64 = 0.8;
const BELOW: f64 = 0.25;

/// Around a label.
const MARGIN: f64 = 2.0;

/// From a place along and upwards to a label: near it first.
const OFFSETS: [(f64, f64); 3] = [(6.0, 5.0), (10.0, 8.0), (16.0, 12.0)];

/// Where a text of that width may stand at such a distance from a place.
fn candidates((x, y): At, (along, up): (f64, f64), width: f64) -> [(At, Anchor); 5] {
    [
        ((x + along, y - up), Anchor::Start),
        ((x - along, y - up), Anchor::End),
        ((x + along, y + up + ABOVE * LETTERS), Anchor::Start),
        ((x - along, y + up + ABOVE * LETTERS), Anchor::End),
        ((x - width / 2.0, y - up - 2.0), Anchor::Start),
    ]
}

/// What a text of that width covers there.
fn room((x, baseline): At, anchor: Anchor, width: f64) -> Rectangle {
    let left = match anchor {
        Anchor::Start => x,
        Anchor::Middle => x - width / 2.0,
        Anchor::End => x - width,
    };
    Rectangle {
        left: left - MARGIN,
        top: baseline - ABOVE * LETTERS - MARGIN,
        width: width + 2.0 * MARGIN,
        height: (ABOVE + BELOW) * LETTERS + 2.0 * MARGIN,
    }
}

/// The first place beside one of `beside` at which a text of that width lies within `area` and
/// touches none of these marks, or else the one at which it touches least; `None` if it fits
/// nowhere within the area. `width_of`: of the texts that are drawn.
pub(super) fn free_place(
    marks: &[&Primitive],
    area: &Rectangle,
    beside: &[At],
    width: f64,
    width_of: impl Fn(&str) -> f64,
) -> Option<(At, Anchor)> {
    let is_inside = |(at, anchor): &(At, Anchor)| {
        let room = room(*at, *anchor, width);
        room.left >= area.left
            && room.top >= area.top
            && room.left + room.width <= area.left + area.width
            && room.top + room.height <= area.top + area.height
    };
    let harm = |(at, anchor): &(At, Anchor)| -> usize {
        let room = room(*at, *anchor, width);
        let touched = marks.iter().filter(|mark| touches(mark, &room, &width_of));
        // two texts in one place cannot be read
        touched.map(|mark| if matches!(mark, Primitive::Text { .. }) { 1000 } else { 1 }).sum()
    };
    let near = |offset| beside.iter().flat_map(move |place| candidates(*place, offset, width));
    let places = || OFFSETS.into_iter().flat_map(near).filter(is_inside);
    places().find(|place| harm(place) == 0).or_else(|| places().min_by_key(harm))
}

fn touches(mark: &Primitive, part: &Rectangle, width_of: &impl Fn(&str) -> f64) -> bool {
    match mark {
        Primitive::Line { points, .. } => points.windows(2).any(|ends| crosses(part, ends[0], ends[1])),
        Primitive::Symbol { at: (x, y), .. } => {
            let reach = Shape::RADIUS + 1.0;
            part.overlaps(&Rectangle { left: x - reach, top: y - reach, width: 2.0 * reach, height: 2.0 * reach })
        }
        Primitive::Text { at, text, anchor, .. } => part.overlaps(&room(*at, *anchor, width_of(text))),
        // what lies on a tinted area can be read
        Primitive::Area { .. } => false,
    }
}

/// Whether a part of the straight line lies in the rectangle (Liang and Barsky).
fn crosses(part: &Rectangle, (x, y): At, (to_x, to_y): At) -> bool {
    let (dx, dy) = (to_x - x, to_y - y);
    let sides =
        [(-dx, x - part.left), (dx, part.left + part.width - x), (-dy, y - part.top), (dy, part.top + part.height - y)];
    let (mut enters, mut leaves) = (0.0_f64, 1.0_f64);
    for (towards, room) in sides {
        if towards == 0.0 {
            if room < 0.0 {
                return false;
            }
        } else if towards < 0.0 {
            enters = enters.max(room / towards);
        } else {
            leaves = leaves.min(room / towards);
        }
    }
    enters <= leaves
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::drawing::{Colour, Dash, Stroke};

    const AREA: Rectangle = Rectangle { left: 0.0, top: 0.0, width: 300.0, height: 200.0 };

    fn drawing_of(lines: &[[At; 2]]) -> Vec<Primitive> {
        let stroke = Stroke { colour: Colour::Ink, width: 1.0, dash: Dash::Solid };
        lines.iter().map(|ends| Primitive::Line { points: ends.to_vec(), stroke }).collect()
    }

    fn free_place_in(
        marks: &[Primitive],
        area: &Rectangle,
        beside: &[At],
        width: f64,
        width_of: impl Fn(&str) -> f64,
    ) -> Option<(At, Anchor)> {
        free_place(&marks.iter().collect::<Vec<_>>(), area, beside, width, width_of)
    }

    #[test]
    fn a_line_crosses_what_it_goes_through() {
        let part = Rectangle { left: 10.0, top: 10.0, width: 20.0, height: 10.0 };
        for (ends, expected) in [
            ([(0.0, 0.0), (40.0, 30.0)], true),
            ([(0.0, 15.0), (300.0, 15.0)], true),
            ([(12.0, 12.0), (13.0, 13.0)], true),
            ([(0.0, 25.0), (300.0, 25.0)], false),
            ([(0.0, 0.0), (9.0, 30.0)], false),
            ([(15.0, 0.0), (15.0, 9.0)], false),
        ] {
            assert_eq!(crosses(&part, ends[0], ends[1]), expected, "{ends:?}");
        }
    }

    #[test]
    fn a_label_keeps_clear_of_lines_and_of_other_labels() {
        // a falling line, and another 12 above it: above right of the lower one there is no room
        let mut drawing = drawing_of(&[[(0.0, 0.0), (300.0, 200.0)], [(18.0, 0.0), (300.0, 188.0)]]);
        let beside: Vec<At> = (1..10).map(|n| (30.0 * f64::from(n), 20.0 * f64::from(n))).collect();
        let width = |text: &str| 7.0 * text.len() as f64;
        for _ in 0..3 {
            let (at, anchor) = free_place_in(&drawing, &AREA, &beside, width("a label"), width).unwrap();
            let room = room(at, anchor, width("a label"));
            assert!(!drawing.iter().any(|mark| touches(mark, &room, &width)), "{at:?}");
            drawing.push(Primitive::text(at, "a label", anchor));
        }
        assert_eq!(free_place_in(&drawing, &AREA, &beside, 400.0, width), None);
        assert_eq!(free_place_in(&drawing, &AREA, &[], 10.0, width), None);
    }

    #[test]
    fn without_free_room_a_label_stands_where_it_touches_least() {
        let lines: Vec<[At; 2]> = (0..40).map(|n| 5.0 * f64::from(n)).map(|y| [(0.0, y), (300.0, y)]).collect();
        assert!(free_place_in(&drawing_of(&lines), &AREA, &[(100.0, 100.0)], 50.0, |_| 50.0).is_some());
    }

    #[test]
    fn a_label_stands_on_lines_before_it_stands_on_another_label() {
        // room above the place for one label, and many lines below it
        let lines: Vec<[At; 2]> = (0..100).map(|n| 101.0 + f64::from(n)).map(|y| [(0.0, y), (300.0, y)]).collect();
        let (mut drawing, area) = (drawing_of(&lines), Rectangle { left: 95.0, ..AREA });
        let mut rooms = Vec::new();
        for _ in 0..2 {
            let (at, anchor) = free_place_in(&drawing, &area, &[(100.0, 100.0)], 50.0, |_| 50.0).unwrap();
            rooms.push(room(at, anchor, 50.0));
            drawing.push(Primitive::text(at, "a label", anchor));
        }
        assert!(!rooms[0].overlaps(&rooms[1]), "{rooms:?}");
    }
}

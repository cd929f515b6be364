//! The programs that take N and K, the two forms of these, and the data sheets they can come from.

use vn100_analysis::{Remedy, axes_name, letter};

use super::{Entry, Explanation, entry};
use crate::{Consumer, DATASHEETS, parse_datasheet};

const PROGRAMS: &str = "Programs that take N and K";

pub(super) fn explanations() -> Vec<Explanation> {
    let programs = Consumer::ALL.iter().map(of_program);
    let sheets = DATASHEETS.iter().filter_map(|(name, text)| of_sheet(name, text));
    VALUES.into_iter().map(|value| entry(PROGRAMS, value)).chain(programs).chain(sheets).collect()
}

/// The forms of N and K, and what is made of them.
const VALUES: [Entry; 3] = [
    (
        ("discrete", &["continuous", "discrete noise", "sigma of a sample"]),
        "N and K in continuous time, and by sample",
        [
            "N and K are continuous densities, which do not depend on the rate. At a rate f the white noise of one sample has the standard \
             deviation N sqrt(f), and the bias walks by K/sqrt(f) from sample to sample. The variance of the angle or velocity is N^2 t, \
             and that of the bias K^2 t, in either form.",
            "A number in the form that a program does not expect is wrong by sqrt(f), often ten times or more. What a program calls its noise \
             depends on its recursion: VINS takes N sqrt(2 f) and K sqrt(f), FAST-LIO N^2 f and K^2 f. The gyr_w and acc_w of imu_utils are \
             the bias instability, and no walk.",
            "Take the file that is written for the program. Explain its name for the formula and the lines of its code.",
        ],
        &[],
        "",
    ),
    (
        ("drift", &["coasting", "dead reckoning"]),
        "drift while coasting",
        [
            "How far angle, velocity and position run away while the sensor coasts, after a rest over which its mean was taken for its bias. \
             If the rest is as long as the coast T, the variance of the angle or velocity is 2 T^2 times the Allan variance at T, with no \
             model. A tilt error times gravity is part of velocity and position: most of it as a rule.",
            "It is what the noise costs. One drift lies within the given limit with the level of the intervals (95 %), the uncertainty of the \
             standard deviation included; the interval of the standard deviation stands apart.",
            "It holds at rest, at constant temperature, for a level start, without an error of the scale factor. A compensated message shows \
             the tracker of the filter, not the sensor: record an uncompensated one. A coast of ten minutes needs a record of an hour or more.",
        ],
        &[Remedy::Plan],
        "IEEE Std 952-1997, annex C; NIST SP 1065; Farrell et al., IEEE Control Systems Magazine 42(6), 2022",
    ),
    (
        ("inflation", &["inflate"]),
        "what a filter takes by the fit",
        [
            "The smallest N and K together whose density N^2 + K^2/(2 pi f)^2 lies above the fitted one at all \
             frequencies from that of a minute of use on; over the estimates, the least factors of inflation. K is no less than the walk \
             that drifts in a minute as the bias instability does, 1.15 B/sqrt(60 s).",
            "White noise and a walk alone lie below the density where flicker, correlated noise or vibration add to it, and a filter is then too sure.",
            "With less, a filter is too sure of the noise of the record. A record at rest knows nothing of scale factor, vibration in motion, timing and linearisation, for which people \
             multiply by ten.",
        ],
        &[],
        "IEEE Std 952-1997, annex C, for the densities of the terms",
    ),
];

fn of_program(consumer: &'static Consumer) -> Explanation {
    let white = format!(
        "N is typed as {} in {} (gyroscope) and {} (accelerometer)",
        consumer.white.text, consumer.white.units.0, consumer.white.units.1
    );
    let (walk, why) = match consumer.walk {
        Some(walk) => (
            format!("K as {} in {} and {}", walk.text, walk.units.0, walk.units.1),
            "With these numbers its own recursion gives the variances N^2 t and K^2 t.",
        ),
        None => {
            ("it has no place for K".into(), "With this number the white noise of its samples integrates to N^2 t.")
        }
    };
    Explanation {
        group: PROGRAMS,
        code: consumer.name.into(),
        title: consumer.title.into(),
        meaning: format!("{white}, {walk}. Note: {}.", consumer.remark),
        why,
        advice: "A record at rest knows nothing of scale factor, vibration rectification, timing and linearisation: its values are lower bounds.",
        source: consumer.code,
        ..Explanation::default()
    }
}

fn of_sheet(name: &'static str, text: &str) -> Option<Explanation> {
    let sheet = parse_datasheet(text).ok()?;
    let figures = sheet.figures.iter().map(|figure| {
        let source = figure.source.as_deref().map_or(String::new(), |source| format!(" ({source})"));
        format!("{} {} {}{source}.", axes_name(figure.sensor), letter(figure.term), figure.printed)
    });
    let note = sheet.note.map_or(String::new(), |note| format!("; {note}"));
    Some(Explanation {
        group: "Data sheets",
        code: name.into(),
        title: sheet.name + &note,
        meaning: figures.collect::<Vec<_>>().join(" "),
        why: "A data sheet prints no random walk, and often not which frequencies its densities count.",
        remedies: &[Remedy::GiveDatasheet],
        ..Explanation::default()
    })
}

//! Many samples as a file.

use std::io::{self, Write};

use vn100_protocol::xor8;

use crate::{
    generator::Generator,
    message::Message,
    sensor::{Deltas, SensorValues},
};

/// Appends the sentence of one row of a [`Generator`] and of its temperature (degC) and pressure
/// (kPa), from `$` to LF.
///
/// The angular rates are those of the row in every message: no attitude filter takes a bias out.
pub fn write_sentence(line: &mut Vec<u8>, message: &Message, row: &[f32; 12], [temperature_c, pressure_kpa]: [f32; 2]) {
    let [yaw, pitch, roll, mx, my, mz, ax, ay, az, gx, gy, gz] = *row;
    let (mag_gauss, accel_m_s2, gyro_rad_s) = ([mx, my, mz], [ax, ay, az], [gx, gy, gz]);
    let measured = SensorValues {
        ypr_deg: [yaw, pitch, roll],
        mag_gauss,
        accel_m_s2,
        gyro_rad_s,
        uncompensated_mag_gauss: mag_gauss,
        uncompensated_accel_m_s2: accel_m_s2,
        uncompensated_gyro_rad_s: gyro_rad_s,
        temperature_c,
        pressure_kpa,
    };
    let mut body = message.header.to_owned();
    message.print(&measured, &Deltas::default(), &mut body);
    // writing to a Vec cannot fail
    _ = write!(line, "${body}*{:02X}\r\n", xor8(body.as_bytes()));
}

/// Appends the generator's next row as a sentence.
pub fn write_next(line: &mut Vec<u8>, message: &Message, generator: &mut Generator) {
    let row = generator.next_row();
    let surroundings = if message.has_surroundings() { generator.next_surroundings() } else { [0.0; 2] };
    write_sentence(line, message, &row, surroundings);
}

/// Writes the next `samples` rows of the generator, one sentence each; zero writes nothing.
///
/// Each sentence is one write: give a buffered writer, and flush it.
///
/// # Errors
/// The first error of the writer; what was written until then stays.
pub fn write_capture(
    out: &mut impl Write,
    generator: &mut Generator,
    message: &Message,
    samples: u64,
) -> io::Result<()> {
    let mut line = Vec::new();
    for _ in 0..samples {
        line.clear();
        write_next(&mut line, message, generator);
        out.write_all(&line)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sentences of real sensors: still, moving, beyond 100 m/s², with negative zero.
    const REAL: [&str; 8] = [
        "$VNYMR,-085.469,+074.972,+063.752,-00.5551,+00.4403,+00.9048,+08.971,-02.145,-01.093,+00.000040,-00.000301,-00.000391*63\r\n",
        "$VNYMR,-085.476,+074.973,+063.745,-00.5552,+00.4334,+00.9062,+08.992,-02.114,-01.105,+00.002040,-00.000298,-00.000980*6C\r\n",
        "$VNYMR,+148.954,+001.254,+000.995,-00.5664,-00.1587,+00.4170,+00.212,-00.169,-09.817,-00.000168,+00.000295,-00.000137*68\r\n",
        "$VNYMR,-077.616,-001.322,+000.143,+00.0452,+00.2449,-00.3347,-00.249,-00.019,-09.893,+00.001117,+00.000227,-00.000329*63\r\n",
        "$VNYMR,-082.171,-044.329,-135.904,+00.3385,-00.2514,+00.0610,-32.044,+06.154,+01.762,+09.803607,-11.823348,-04.562857*60\r\n",
        "$VNYMR,-118.034,-024.276,-062.915,+00.3261,-00.2790,+00.2276,-39.242,+123.931,-58.612,-00.223137,+02.140320,-03.657718*52\r\n",
        "$VNYMR,-000.326,+088.263,-034.861,-00.2266,+00.2469,-00.5156,-19.679,-40.886,-143.685,-06.326948,-00.046931,-00.119262*55\r\n",
        "$VNYMR,-095.878,+008.933,-009.419,+00.1785,+00.1474,+00.5479,+00.252,-03.706,-03.874,-01.012502,-00.234810,+00.247165*66\r\n",
    ];

    fn printed(header: &str, row: [f32; 12], surroundings: [f32; 2]) -> String {
        let mut line = Vec::new();
        write_sentence(&mut line, Message::named(header).unwrap(), &row, surroundings);
        String::from_utf8(line).unwrap()
    }

    #[test]
    fn real_sentences_are_printed_alike() {
        for real in REAL {
            let fields = real[7..real.len() - 5].split(',').map(|field| field.parse::<f32>().unwrap());
            let row: Vec<f32> = fields.collect();
            assert_eq!(printed("VNYMR", row.try_into().unwrap(), [0.0; 2]), real);
        }
    }

    #[test]
    fn negative_zero_keeps_its_sign() {
        let text = printed("VNYMR", [-0.0; 12], [0.0; 2]);
        assert!(text.starts_with("$VNYMR,-000.000,"), "{text}");
        assert!(text.contains(",-00.0000,") && text.contains(",-00.000,"), "{text}");
        assert!(text.contains(",-00.000000*"), "{text}");
    }

    #[test]
    fn each_message_has_its_part_of_the_row() {
        let row = [0.0, 0.0, 90.0, -2.0841, 0.6045, 2.8911, 0.381, -0.154, -9.657, -0.005683, 0.000262, 0.001475];
        let inertial = "-02.0841,+00.6045,+02.8911,+00.381,-00.154,-09.657,-00.005683,+00.000262,+00.001475";
        for (header, body) in [
            ("VNYMR", format!("VNYMR,+000.000,+000.000,+090.000,{inertial}")),
            ("VNIMU", format!("VNIMU,{inertial},+21.6,+00099.761")),
            ("VNMAR", format!("VNMAR,{inertial}")),
            ("VNQMR", format!("VNQMR,+0.707107,+0.000000,+0.000000,+0.707107,{inertial}")),
        ] {
            assert_eq!(printed(header, row, [21.6, 99.761]).split('*').next().unwrap()[1..], body);
        }
        assert!(Message::named("VNXYZ").is_none());
    }

    #[test]
    fn sentences_append() {
        let message = Message::named("VNYMR").unwrap();
        let mut twice = Vec::new();
        write_sentence(&mut twice, message, &[1.0; 12], [0.0; 2]);
        let once = twice.clone();
        write_sentence(&mut twice, message, &[1.0; 12], [0.0; 2]);
        assert_eq!(twice, once.repeat(2));
        assert_eq!(once.len(), 122);
    }
}

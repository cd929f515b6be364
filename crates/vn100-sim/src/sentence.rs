//! One sample as the sensor prints it.

use std::io::Write;

/// Appends the `$VNYMR` sentence of one row: yaw, pitch, roll (deg), magnetic field x y z (gauss),
/// acceleration x y z (m/s²), angular rate x y z (rad/s).
///
/// ```text
/// $VNYMR,+ddd.ddd x3,+dd.dddd x3,+dd.ddd x3,+dd.dddddd x3*HH CR LF
/// ```
///
/// `HH` is the XOR of all bytes between `$` and `*`. Widths are minimum widths: 122 bytes in all,
/// more from 100 m/s² on. Negative zero keeps its sign. The text equals that of the C formats
/// `%+08.3f`, `%+08.4f`, `%+07.3f` and `%+010.6f`; a value that is not finite prints as Rust prints
/// it.
///
/// This encoder shares nothing with the project's parser, so that each can be held against the
/// other.
pub fn write_sentence(line: &mut Vec<u8>, row: &[f32; 12]) {
    let start = line.len();
    let [yaw, pitch, roll, mag @ .., _, _, _, _, _, _] = row;
    let [.., ax, ay, az, gx, gy, gz] = row;
    let [mx, my, mz] = mag;
    // writing to a Vec cannot fail
    _ = write!(
        line,
        "$VNYMR,{yaw:+08.3},{pitch:+08.3},{roll:+08.3},{mx:+08.4},{my:+08.4},{mz:+08.4},\
         {ax:+07.3},{ay:+07.3},{az:+07.3},{gx:+010.6},{gy:+010.6},{gz:+010.6}"
    );
    end_sentence(line, start);
}

/// Appends the `$VNIMU` sentence of one row and of its temperature (degC) and pressure (kPa): the
/// values of the row but for the angles, in the same formats, then `%+05.1f` and `%+010.3f`.
/// Otherwise as [`write_sentence`].
pub fn write_imu_sentence(line: &mut Vec<u8>, row: &[f32; 12], [temperature_c, pressure_kpa]: [f32; 2]) {
    let start = line.len();
    let [_, _, _, mx, my, mz, ax, ay, az, gx, gy, gz] = row;
    // writing to a Vec cannot fail
    _ = write!(
        line,
        "$VNIMU,{mx:+08.4},{my:+08.4},{mz:+08.4},{ax:+07.3},{ay:+07.3},{az:+07.3},{gx:+010.6},{gy:+010.6},{gz:+010.6},\
         {temperature_c:+05.1},{pressure_kpa:+010.3}"
    );
    end_sentence(line, start);
}

/// Appends the check and the line's end to what stands behind `start`.
fn end_sentence(line: &mut Vec<u8>, start: usize) {
    let check = line[start + 1..].iter().fold(0, |xor, byte| xor ^ byte);
    _ = write!(line, "*{check:02X}\r\n");
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lines of real sensors: still, moving, beyond 100 m/s², with negative zero.
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

    #[test]
    fn real_lines_come_back() {
        let mut line = Vec::new();
        for real in REAL {
            let fields = real[7..real.len() - 5].split(',').map(|field| field.parse::<f32>().unwrap());
            let row: Vec<f32> = fields.collect();
            line.clear();
            write_sentence(&mut line, &row.try_into().unwrap());
            assert_eq!(std::str::from_utf8(&line), Ok(real));
        }
    }

    #[test]
    fn negative_zero_keeps_its_sign() {
        let mut line = Vec::new();
        write_sentence(&mut line, &[-0.0; 12]);
        let text = String::from_utf8(line).unwrap();
        assert!(text.starts_with("$VNYMR,-000.000,"), "{text}");
        assert!(text.contains(",-00.0000,") && text.contains(",-00.000,"), "{text}");
        assert!(text.contains(",-00.000000*"), "{text}");
    }

    #[test]
    fn the_uncompensated_message_has_temperature_and_pressure() {
        let row = [0.0, 0.0, 0.0, -2.0841, 0.6045, 2.8911, 0.381, -0.154, -9.657, -0.005683, 0.000262, 0.001475];
        let mut line = Vec::new();
        write_imu_sentence(&mut line, &row, [21.6, 99.761]);
        let expected = "$VNIMU,-02.0841,+00.6045,+02.8911,+00.381,-00.154,-09.657,-00.005683,+00.000262,+00.001475,+21.6,+00099.761*";
        let text = String::from_utf8(line).unwrap();
        assert!(text.starts_with(expected), "{text}");
    }

    #[test]
    fn sentences_append() {
        let mut twice = Vec::new();
        write_sentence(&mut twice, &[1.0; 12]);
        let once = twice.clone();
        write_sentence(&mut twice, &[1.0; 12]);
        assert_eq!(twice, once.repeat(2));
        assert_eq!(once.len(), 122);
    }
}

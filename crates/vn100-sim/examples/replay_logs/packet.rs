//! Binary packets of the sensor between sentences.

/// ```text
/// FA | groups 01 | fields 39 07 | payload, 104 bytes, little-endian | CRC-16, high byte first
/// ```
///
/// Fields: time since start-up (ns) | yaw pitch roll | quaternion | angular rate | acceleration |
/// uncompensated acceleration, angular rate | magnetic field, temperature, pressure.
///
/// The packets are 5 ms apart. `uncompensated` replaces that field by bytes of any meaning.
pub(crate) fn packet(number: u64, row: &[f32; 12], uncompensated: Option<&[u8; 24]>) -> Vec<u8> {
    const BIAS_RAD_S: [f32; 3] = [0.0198, -0.0298, -0.0105];
    const TEMPERATURE_C: f32 = 33.65;
    const PRESSURE_KPA: f32 = 101.423;
    let [yaw, pitch, roll, mag @ .., _, _, _, _, _, _] = row;
    let [.., ax, ay, az, gx, gy, gz] = row;
    let mut packet = vec![0xFA, 0x01, 0x39, 0x07];
    let time_ns = 12_000_000_000 + number * 5_000_000;
    packet.extend(time_ns.to_le_bytes());
    push(&mut packet, &[*yaw, *pitch, *roll]);
    push(&mut packet, &quaternion(*yaw, *pitch, *roll));
    push(&mut packet, &[*gx, *gy, *gz]);
    push(&mut packet, &[*ax, *ay, *az]);
    match uncompensated {
        Some(bytes) => packet.extend(bytes),
        None => {
            let [bx, by, bz] = BIAS_RAD_S;
            push(&mut packet, &[*ax, *ay, *az, gx + bx, gy + by, gz + bz]);
        }
    }
    push::<3>(&mut packet, mag);
    push(&mut packet, &[TEMPERATURE_C, PRESSURE_KPA]);
    let crc = crc16(&packet[1..]);
    packet.extend(crc.to_be_bytes());
    packet
}

/// Makes the CRC of a packet wrong.
pub(crate) fn break_crc(packet: &mut [u8]) {
    if let Some(last) = packet.last_mut() {
        *last ^= 0x01;
    }
}

/// CRC-16/XMODEM: polynomial 0x1021, start 0.
pub(crate) fn crc16(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0, |crc, &byte| {
        (0..8).fold(
            crc ^ (u16::from(byte) << 8),
            |crc, _| {
                if crc & 0x8000 == 0 { crc << 1 } else { (crc << 1) ^ 0x1021 }
            },
        )
    })
}

fn push<const N: usize>(packet: &mut Vec<u8>, values: &[f32; N]) {
    packet.extend(values.iter().flat_map(|value| value.to_le_bytes()));
}

/// The quaternion of Euler angles 3-2-1 in degrees; the scalar comes last.
fn quaternion(yaw_deg: f32, pitch_deg: f32, roll_deg: f32) -> [f32; 4] {
    let half = |angle_deg: f32| (angle_deg.to_radians() / 2.0).sin_cos();
    let ((sy, cy), (sp, cp), (sr, cr)) = (half(yaw_deg), half(pitch_deg), half(roll_deg));
    [sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy, cr * cp * cy + sr * sp * sy]
}

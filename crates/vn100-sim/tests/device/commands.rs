//! Commands and registers.

use vn100_sim::DeviceConfig;

use crate::bench::Bench;

/// Replies of real units and of the maker's documents, to reads of a sensor as delivered.
const READ: [&str; 12] = [
    "$VNRRG,01,VN-100S-CR*35",
    "$VNRRG,02,7*6A",
    "$VNRRG,03,0100130608*51",
    "$VNRRG,04,3.1.0.0*77",
    "$VNRRG,05,115200*5D",
    "$VNRRG,06,14*5C",
    "$VNRRG,07,40*5C",
    "$VNRRG,30,0,0,0,0,1,0,1*6C",
    "$VNRRG,32,3,0,0,0,0,0,0,100000000,0*6C",
    "$VNRRG,35,1,1,1,1*75",
    "$VNRRG,44,0,1,5*6B",
    "$VNRRG,75,0,0,01,0001*71",
];

#[test]
fn a_sensor_as_delivered_reads_as_real_units_do() {
    let mut bench = Bench::quiet(DeviceConfig { serial: 100_130_608, ..DeviceConfig::default() });
    for reply in READ {
        assert_eq!(bench.ask(&reply[1..9]), [reply]);
    }
}

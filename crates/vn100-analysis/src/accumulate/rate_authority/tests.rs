//! Which source holds the rate, and what each change of it does to the record.

use std::time::Duration;

use vn100_protocol::VNYMR;

use super::*;

fn span(samples: usize, excluded: usize) -> MeasuredSpan {
    let mut span = MeasuredSpan::new(Duration::ZERO, None);
    span.push(excluded, 40.0, true);
    span.push(samples, 40.0, false);
    span
}

fn summary(nominal: Option<NominalRate>, offset_ppm: Option<f64>) -> TimebaseSummary {
    TimebaseSummary {
        samples: 500,
        backwards: 0,
        nominal,
        measured_hz: None,
        offset_ppm,
        refusal: None,
        missing: 0,
        gaps: 0,
        unevenness: None,
        flushed: 0,
        arrivals: None,
    }
}

fn snapped(hz: f64) -> TimebaseSummary {
    summary(Some(NominalRate::Snapped(hz)), Some(1.0))
}

#[test]
fn device_times_at_the_rate_of_the_record_end_an_exclusion() {
    let mut rate = RateAuthority::new(None);
    assert!(matches!(rate.take_device_time(800.0, &span(0, 0)), RateEffect::Discard { .. }));
    assert_eq!(rate.take_device_time(800.0, &span(9, 0)), RateEffect::None);
    assert_eq!(rate.take_device_time(200.0, &span(9, 0)), RateEffect::Exclude);
    assert!(rate.is_excluding() && rate.hz() == 800.0);
    assert_eq!(rate.take_device_time(800.0, &span(9, 5)), RateEffect::Resume);
    assert!(!rate.is_excluding() && rate.other_rate_samples == 5);
}

fn by_arrival(hz: f64) -> RateAuthority {
    let mut rate = RateAuthority::new(None);
    rate.set_layout(&VNYMR);
    assert_eq!(rate.take_nominal(NominalRate::Snapped(hz), None, &span(0, 0)), RateEffect::None);
    rate
}

fn by_device(hz: f64) -> RateAuthority {
    let mut rate = RateAuthority::new(None);
    rate.set_layout(&VNYMR);
    assert_eq!(rate.take_device_rate(hz, || None, &span(0, 0)), RateEffect::Known(hz));
    rate
}

fn by_user(hz: f64) -> RateAuthority {
    let mut rate = RateAuthority::new(Some(hz));
    rate.set_layout(&VNYMR);
    rate
}

#[test]
fn arrival_times_decide_until_the_user_or_the_sensor_does() {
    let assumed = RateAuthority::new(None);
    assert_eq!((assumed.hz(), assumed.rate.from, assumed.is_open()), (40.0, RateFrom::Assumed, true));
    for (rate, from) in
        [(by_user(25.0), RateFrom::Option), (by_device(25.0), RateFrom::Device), (by_arrival(25.0), RateFrom::Arrival)]
    {
        assert_eq!((rate.hz(), rate.rate.from, rate.is_open()), (25.0, from, false));
    }
}

#[test]
fn where_arrival_times_and_the_sensor_agree_the_sensor_is_the_authority() {
    let mut rate = RateAuthority::new(None);
    assert_eq!(rate.take_nominal(NominalRate::Measured(33.0), Some(33.0), &span(0, 0)), RateEffect::None);
    assert_eq!((rate.hz(), rate.rate.from), (33.0, RateFrom::Device));
    assert_eq!(rate.take_nominal(NominalRate::Measured(34.0), Some(33.0), &span(0, 0)), RateEffect::None);
    assert_eq!((rate.hz(), rate.rate.from), (34.0, RateFrom::Arrival));
    assert_eq!(rate.take_device_rate(34.0, || None, &span(9, 0)), RateEffect::None);
    assert_eq!(rate.rate.from, RateFrom::Device);
    let mut given = by_user(25.0);
    assert_eq!(given.take_nominal(NominalRate::Known(25.0), Some(25.0), &span(0, 0)), RateEffect::None);
    assert_eq!((given.hz(), given.rate.from), (25.0, RateFrom::Option));
    assert_eq!(given.take_device_rate(50.0, || Some(snapped(25.0)), &span(9, 0)), RateEffect::None);
    assert_eq!((given.hz(), given.rate.from), (25.0, RateFrom::Option));
}

#[test]
fn a_rate_by_few_samples_gives_way() {
    let (mut rate, mut assumed) = (by_arrival(50.0), RateAuthority::new(None));
    rate.doubt();
    assumed.doubt();
    assert!(rate.is_open() && !assumed.rate.is_by_few, "one sample has no rate");
    assert_eq!(rate.take_device_rate(40.0, || None, &span(9, 0)), RateEffect::Known(40.0));
}

#[test]
fn samples_at_another_rate_are_excluded_until_it_is_that_of_the_record() {
    let mut rate = by_arrival(40.0);
    assert_eq!(rate.take_change(40.0, 200.0, Some(snapped(40.0)), &span(600, 7)), RateEffect::Exclude);
    assert_eq!(rate.change(), Some(RateChange { after_samples: 600, from_hz: 40.0, to_hz: 200.0 }));
    assert_eq!((rate.hz(), rate.is_excluding()), (40.0, true));
    assert_eq!(rate.arrivals(|| None), Some(snapped(40.0)), "of the samples that count");
    assert_eq!(rate.take_change(200.0, 100.0, None, &span(600, 50)), RateEffect::None);
    assert_eq!(rate.take_change(100.0, 40.0, None, &span(600, 107)), RateEffect::Resume);
    assert_eq!((rate.change(), rate.is_excluding(), rate.other_rate_samples), (None, false, 100));
    assert_eq!(rate.arrivals(|| Some(snapped(10.0))), Some(snapped(10.0)));
}

#[test]
fn a_sensor_that_reports_another_rate_was_set_anew_if_the_stamps_confirmed_the_old_one() {
    let mut device = by_device(40.0);
    assert_eq!(device.take_device_rate(40.0, || None, &span(600, 0)), RateEffect::None);
    assert_eq!(device.take_device_rate(20.0, || Some(snapped(50.0)), &span(600, 0)), RateEffect::Exclude);
    assert_eq!(device.arrivals(|| Some(snapped(20.0))), None, "none was at the rate of the record");
    let mut device = by_device(40.0);
    device.end_connection(Some(snapped(40.0)));
    assert_eq!(device.take_device_rate(20.0, || Some(snapped(20.0)), &span(600, 0)), RateEffect::Exclude);
    assert_eq!(device.arrivals(|| None), Some(snapped(40.0)));

    let effect = |now: Option<TimebaseSummary>| {
        let mut rate = by_arrival(40.0);
        assert_eq!(rate.take_device_rate(40.0, || None, &span(600, 0)), RateEffect::None);
        rate.rate.from = RateFrom::Arrival;
        rate.take_device_rate(20.0, || now, &span(600, 0))
    };
    assert_eq!(effect(Some(snapped(40.0))), RateEffect::Exclude);
    let off = |ppm| Some(summary(Some(NominalRate::Snapped(40.0)), Some(ppm)));
    assert_eq!((effect(off(999.0)), effect(off(-999.0))), (RateEffect::Exclude, RateEffect::Exclude));
    assert_eq!((effect(off(1000.0)), effect(off(-1001.0))), (RateEffect::Replace(20.0), RateEffect::Replace(20.0)));
    assert_eq!(effect(Some(summary(Some(NominalRate::Measured(40.0)), Some(0.0)))), RateEffect::Replace(20.0));
    assert_eq!(effect(None), RateEffect::Replace(20.0));
    let mut changed = by_arrival(40.0);
    assert_eq!(changed.take_change(40.0, 50.0, None, &span(600, 0)), RateEffect::Exclude);
    assert_eq!(changed.take_device_rate(20.0, || None, &span(600, 9)), RateEffect::None);
}

#[test]
fn arrivals_outweigh_a_report_that_they_contradict() {
    let report = |reported_hz| Some(Finding::FalseReport { reported_hz, arrival_hz: 100.0 });
    let arrivals = NominalRate::Snapped(100.0);
    for samples in [0, 600] {
        let mut rate = by_device(40.0);
        let expected = RateEffect::Discard { from_hz: 40.0, to_hz: 100.0 };
        assert_eq!(rate.take_nominal(arrivals, Some(40.0), &span(samples, 0)), expected);
        assert_eq!((rate.hz(), rate.rate.from, rate.false_report.clone()), (100.0, RateFrom::Arrival, report(40.0)));
        let now = || Some(snapped(100.0));
        assert_eq!(rate.take_device_rate(40.0, now, &span(700, 0)), RateEffect::None, "the same again");
        rate.end_connection(now());
        assert_eq!(rate.take_device_rate(40.0, || None, &span(700, 0)), RateEffect::None, "behind a reconnect");
        assert_eq!(rate.take_device_rate(50.0, now, &span(700, 0)), RateEffect::Exclude, "it was set");
        assert_eq!(rate.false_report, None);
    }
    let mut changed = by_device(40.0);
    changed.end_connection(Some(snapped(40.0)));
    assert_eq!(changed.take_nominal(arrivals, Some(40.0), &span(600, 0)), RateEffect::Exclude);
    assert_eq!(changed.false_report, None, "those before confirmed it");

    let mut late = by_arrival(100.0);
    assert_eq!(late.take_device_rate(40.0, || Some(snapped(100.0)), &span(600, 0)), RateEffect::None);
    assert_eq!((late.hz(), late.false_report.clone()), (100.0, report(40.0)));
    assert_eq!(late.take_change(100.0, 40.0, None, &span(900, 0)), RateEffect::Exclude);
    assert_eq!(late.false_report, None, "the arrivals followed it");
}

#[test]
fn a_false_rate_is_replaced_and_named_where_samples_were_judged_by_it() {
    for (samples, expected) in
        [(0, None), (7, Some(Finding::FalseRate { samples: 7, arrival_hz: 37.0, device_hz: 40.0 }))]
    {
        let mut rate = by_arrival(37.0);
        rate.end_connection(Some(TimebaseSummary {
            refusal: Some(Refusal::NoTimePasses { samples: 2 }),
            ..snapped(1.0)
        }));
        rate.replace(40.0, samples);
        assert_eq!((rate.false_rate.clone(), rate.refused_before), (expected, None));
        assert_eq!((rate.hz(), rate.rate.from), (40.0, RateFrom::Device));
        rate.start_over();
        assert_eq!(rate.false_rate, None);
    }
}

#[test]
fn a_short_connection_does_not_hide_what_a_long_one_showed() {
    let of = |samples, nominal| TimebaseSummary { samples, ..summary(nominal, Some(1.0)) };
    let rate_of = |hz| Some(NominalRate::Snapped(hz));
    let mut rate = by_arrival(40.0);
    for samples in [100, 9000, 20] {
        rate.end_connection(Some(of(samples, rate_of(40.0))));
    }
    let shown = |now| rate.arrivals(|| now).unwrap();
    for shorter in [None, Some(of(0, None)), Some(of(300, rate_of(40.0)))] {
        assert_eq!(shown(shorter), of(9000, rate_of(40.0)));
    }
    let refused = TimebaseSummary { refusal: Some(Refusal::Backwards { times: 9, samples: 300 }), ..of(300, None) };
    for other in [of(9001, rate_of(40.0)), of(300, rate_of(50.0)), refused] {
        assert_eq!(shown(Some(other)), other);
    }
}

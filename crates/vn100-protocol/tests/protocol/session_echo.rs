//! The request machine on a line that echoes, such as a half-duplex line.

use vn100_protocol::{Handled, Register, RequestFailure, RequestQueue, SensorCommand};

use crate::support::bench::{Bench, READ_RATE, write_rate};

#[test]
fn on_a_line_that_echoes_the_first_copy_is_no_answer() {
    let mut bench = Bench::new();
    let rate = bench.submit(READ_RATE);
    bench.sent();
    assert_eq!(bench.hear("VNRRG,07"), Handled::Echo);
    assert_eq!(bench.session.poll_completion(), None);
    assert_eq!(bench.hear("VNRRG,07,40"), Handled::Mine);
    assert_eq!(bench.value(rate), "40");
    for command in [write_rate(20), SensorCommand::Async(false)] {
        let refused = bench.submit(command.clone());
        let [line] = &bench.sent()[..] else { panic!("one line") };
        let body = &line[1..line.len() - 3];
        assert_eq!(bench.hear(body), Handled::Echo);
        assert_eq!(bench.hear("VNERR,0C"), Handled::Mine);
        assert!(matches!(bench.failure(refused), RequestFailure::Device { error, .. } if error.code() == 0x0C));
        let taken = bench.submit(command);
        bench.sent();
        // the reply is lost, and the command is sent again
        assert_eq!(bench.hear(body), Handled::Echo);
        bench.wait(500);
        bench.sent();
        assert_eq!((bench.hear(body), bench.hear(body)), (Handled::Echo, Handled::Mine));
        bench.answer(taken);
        bench.wait(500);
    }
    // another line may follow
    bench.session.handle_link_down();
    let pause = bench.submit(SensorCommand::Async(false));
    bench.sent();
    assert_eq!(bench.hear("VNASY,0"), Handled::Mine);
    bench.answer(pause);
}

#[test]
fn a_register_printed_as_nothing_does_not_make_the_line_echo() {
    let mut bench = Bench::new();
    let tag = bench.submit(SensorCommand::ReadRegister(Register(0)));
    for _ in 0..RequestQueue::ATTEMPTS {
        bench.sent();
        bench.hear("VNRRG,00");
        bench.wait(500);
    }
    bench.failure(tag);
    let pause = bench.submit(SensorCommand::Async(false));
    bench.wait(500);
    bench.sent();
    assert_eq!(bench.hear("VNASY,0"), Handled::Mine);
    bench.answer(pause);
}

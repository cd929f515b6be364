//! What a sensor refuses after it was asked at wrong speeds.

use vn100_protocol::{Fields, RegisterContents};

use super::*;

/// A read that a caller asks for, and its answer.
fn asked(conversation: &mut Conversation) -> oneshot::Receiver<Result<Answer, CommandError>> {
    let (sender, answered) = oneshot::channel();
    conversation.ask(Request { command: Command::ReadRegister(Register::MODEL), answer: Some(sender) });
    answered
}

#[test]
fn until_the_first_good_answer_refusals_may_be_of_junk_and_then_no_more() {
    let refusal = Reply::Error(DeviceError::InvalidCommand);
    let fields = Fields::new("VN-100S-CR").unwrap();
    let model = Reply::Register(RegisterContents { register: Register::MODEL, fields, check: Check::Xor8 });
    let mut conversation = Conversation::new(false, None);
    let mut now = Duration::ZERO;
    conversation.expect_junk_answers();
    assert_eq!(conversation.take_reply(&refusal, now), [], "before anything is asked");
    let mut answered = asked(&mut conversation);
    for _ in 0..2 {
        assert!(conversation.next_line(now, None).is_some(), "it is asked again");
        assert_eq!(conversation.take_reply(&refusal, now), []);
        assert!(answered.try_recv().is_err());
    }
    assert!(conversation.next_line(now, None).is_some());
    conversation.take_reply(&model, now);
    assert!(answered.try_recv().unwrap().is_ok());
    now += READ_EVERY;
    assert_eq!(conversation.take_reply(&refusal, now), [Consequence::Unasked(DeviceError::InvalidCommand)]);
    // and a sensor that refuses for ever is not asked for ever
    conversation.expect_junk_answers();
    let mut answered = asked(&mut conversation);
    for attempt in 0.. {
        assert!(conversation.next_line(now, None).is_some());
        conversation.take_reply(&refusal, now);
        if let Ok(told) = answered.try_recv() {
            assert_eq!((attempt, told.is_err()), (BAUD_RATES.len(), true));
            break;
        }
    }
}

//! What comes from outside is read whatever it is.

use proptest::prelude::*;

use crate::{Config, Frame, Identity, NodeReport};

proptest! {
    #[test]
    fn any_bytes_are_a_frame_or_too_short(bytes: Vec<u8>) {
        let split = Frame::split(&bytes);
        prop_assert_eq!(split.is_some(), bytes.len() >= Frame::BYTES);
        if let Some((frame, packets)) = split {
            let again: Vec<u8> = frame.bytes().into_iter().chain(packets.iter().copied()).collect();
            prop_assert_eq!(again, bytes);
        }
    }

    #[test]
    fn any_bytes_are_packets_or_not(bytes: Vec<u8>, most in 0_usize..300) {
        let mut again = Vec::new();
        let (mut rest, mut longest) = (&bytes[..], 0);
        while let Some((packet, others)) = Frame::next(rest) {
            Frame::add(&mut again, packet);
            longest = longest.max(packet.len());
            rest = others;
        }
        again.extend_from_slice(rest);
        prop_assert_eq!(&again, &bytes);
        prop_assert_eq!(Frame::is_whole(&bytes, most), rest.is_empty() && longest <= most);
    }

    #[test]
    fn any_words_are_an_identity_or_none(key in "[0-9a-f/.host]{0,60}") {
        if let Some(identity) = Identity::from_key(&key) {
            prop_assert_eq!(Identity::from_key(&identity.to_key()), Some(identity));
        }
    }

    #[test]
    fn any_words_are_a_report_or_none(bytes: Vec<u8>, text in r#"[{}\[\]":,a-z0-9]{0,80}"#) {
        prop_assert!(NodeReport::parse(&bytes).is_none());
        prop_assert!(NodeReport::parse(text.as_bytes()).is_none());
    }

    #[test]
    fn any_words_are_a_configuration_or_refused(text in r#"[a-z= '\[\]\n0-9.]{0,80}"#) {
        prop_assert!(Config::parse(&text).is_err());
    }
}

use std::collections::BTreeMap;

use crate::{Identity, Place};

/// Who says that it is at which place, in the order of their coming.
///
/// The first has the place until it is gone: nobody takes it from a process that is there by saying to be another one.
#[derive(Debug)]
pub(super) struct Claims {
    nodes: u16,
    places: BTreeMap<Place, Vec<Identity>>,
}

/// Those that are remembered for a place: the one that has it, and such as come before its end was seen.
const CLAIMS_MAX: usize = 4;

impl Claims {
    /// Of a mesh of so many nodes.
    pub(super) const fn new(nodes: u16) -> Self {
        Self { nodes, places: BTreeMap::new() }
    }

    /// A process has come or gone: who has lost its place by that, then who has got one; `None` for what no process of the mesh says.
    pub(super) fn change(
        &mut self,
        identity: Identity,
        is_there: bool,
    ) -> Option<Vec<(Identity, bool)>> {
        let place = identity.place;
        if place != Place::HOST && place.id().0 >= self.nodes {
            return None;
        }
        let claims = self.places.entry(place).or_default();
        let before = claims.first().cloned();
        match (claims.iter().position(|claim| *claim == identity), is_there) {
            (None, true) if claims.len() < CLAIMS_MAX => claims.push(identity),
            (Some(at), false) => {
                claims.remove(at);
            }
            (None, _) => return None,
            (Some(_), true) => {}
        }
        let after = claims.first().cloned();
        if before == after {
            return Some(Vec::new());
        }
        let lost = before.map(|identity| (identity, false));
        Some(lost.into_iter().chain(after.map(|identity| (identity, true))).collect())
    }

    /// Who has a place.
    pub(super) fn holder(&self, place: Place) -> Option<&Identity> {
        self.places.get(&place)?.first()
    }
}

#[cfg(test)]
mod tests {
    use kiloray_core::network::NodeId;

    use super::*;

    fn identity(node: u16, incarnation: u32) -> Identity {
        let place = Place::new(NodeId(node));
        Identity { place, incarnation, version: "1".into(), scene: 0, share: 0, job: 0 }
    }

    #[test]
    fn who_comes_first_has_the_place_until_it_is_gone() {
        let mut claims = Claims::new(3);
        let (first, second, third) = (identity(1, 7), identity(1, 8), identity(1, 9));
        let place = first.place;
        assert_eq!(claims.change(first.clone(), true), Some(vec![(first.clone(), true)]));
        assert_eq!(claims.change(first.clone(), true), Some(vec![]));
        assert_eq!(claims.change(second.clone(), true), Some(vec![]));
        assert_eq!(claims.change(third.clone(), true), Some(vec![]));
        assert_eq!(claims.holder(place), Some(&first));
        assert_eq!(claims.change(second, false), Some(vec![]));
        let both = vec![(first.clone(), false), (third.clone(), true)];
        assert_eq!(claims.change(first, false), Some(both));
        assert_eq!(claims.change(third.clone(), false), Some(vec![(third, false)]));
        assert_eq!(claims.holder(place), None);
    }

    #[test]
    fn what_no_process_says_is_refused_and_takes_no_room() {
        let mut claims = Claims::new(3);
        assert_eq!(claims.change(identity(3, 1), true), None);
        assert_eq!(claims.change(identity(2, 1), false), None);
        let kept = (0..1000).filter(|&n| claims.change(identity(2, n), true).is_some()).count();
        assert_eq!(kept, CLAIMS_MAX);
    }
}

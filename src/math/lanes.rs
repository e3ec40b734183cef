//! Sets of up to 32 lanes, as the bits of a number: bit 0 for the first lane.

/// The members of a set of lanes, in order.
#[inline(always)]
pub fn lanes(mut set: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = set.trailing_zeros() as usize;
        (set != 0).then(|| {
            set &= set - 1;
            lane
        })
    })
}

#[cfg(test)]
mod tests {
    use super::lanes;

    #[test]
    fn the_members_of_a_set_are_in_order() {
        assert_eq!(lanes(0b1000_0101).collect::<Vec<_>>(), [0, 2, 7]);
        assert_eq!(lanes(1 << 31).collect::<Vec<_>>(), [31]);
        assert_eq!(lanes(u32::MAX).count(), 32);
        assert_eq!(lanes(0).count(), 0);
    }
}

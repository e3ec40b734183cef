use super::super::lanes;

#[test]
fn the_members_of_a_set_are_in_order() {
    assert_eq!(lanes(0b1000_0101).collect::<Vec<_>>(), [0, 2, 7]);
    assert_eq!(lanes(1 << 31).collect::<Vec<_>>(), [31]);
    assert_eq!(lanes(u32::MAX).count(), 32);
    assert_eq!(lanes(0).count(), 0);
}

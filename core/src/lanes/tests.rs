use proptest::prelude::*;

use super::*;

/// Every operation once, in a chain in which each result counts.
struct Chain([[f64; LANES]; 3]);

impl Kernel for Chain {
    type Output = [f64; LANES];

    #[inline(always)]
    fn run<L: Lanes>(self, machine: L::Machine) -> [f64; LANES] {
        let [a, b, c] = [&self.0[0], &self.0[1], &self.0[2]].map(|v| L::load(machine, v));
        let two = L::splat(machine, 2.0);
        let mut sum = a * b + c;
        sum += (a - b).abs().sqrt() / (two + c * c);
        sum -= a.or_greater(b) * b.or_lesser(c) + a.after(b);
        a.where_greater(c, sum, sum * two).to_array()
    }
}

/// `before`: the number in the lane before.
fn one_by_one([a, b, c]: [f64; 3], before: f64) -> f64 {
    let mut sum = a * b + c;
    sum += (a - b).abs().sqrt() / (2.0 + c * c);
    sum -= a.max(b) * b.min(c) + before;
    if a > c { sum } else { sum * 2.0 }
}

proptest! {
    #[test]
    fn all_widths_give_the_bits_of_one_by_one(numbers in prop::array::uniform3(prop::array::uniform4(-10.0..10.0_f64))) {
        let [a, b, _] = numbers;
        let before = [b[3], a[0], a[1], a[2]];
        let lane = |lane: usize| one_by_one(numbers.map(|v| v[lane]), before[lane]);
        let expect = [lane(0), lane(1), lane(2), lane(3)].map(f64::to_bits);
        prop_assert_eq!(run(Chain(numbers)).map(f64::to_bits), expect);
        prop_assert_eq!(Chain(numbers).run::<f64x4>(()).map(f64::to_bits), expect);
    }
}

/// Takes from some of eight numbers.
struct AddWhere([f32; 8], u8);

impl Kernel for AddWhere {
    type Output = ([u32; 8], u8);

    #[inline(always)]
    fn run<L: Lanes>(mut self, machine: L::Machine) -> ([u32; 8], u8) {
        let are_least = L::add_where(machine, &mut self.0, self.1, -0.7, -3.1);
        (self.0.map(f32::to_bits), are_least)
    }
}

proptest! {
    #[test]
    fn numbers_are_added_to_where_bits_are_set(numbers in prop::array::uniform8(-3.1..3.1_f32), bits in any::<u8>()) {
        let mut expect = ([0; 8], 0);
        for (lane, (expect_number, number)) in expect.0.iter_mut().zip(numbers).enumerate() {
            let is_set = bits >> lane & 1 == 1;
            let sum = (number + if is_set { -0.7 } else { 0.0 }).max(-3.1);
            *expect_number = sum.to_bits();
            expect.1 |= u8::from(sum == -3.1) << lane;
        }
        prop_assert_eq!(run(AddWhere(numbers, bits)), expect);
        prop_assert_eq!(AddWhere(numbers, bits).run::<f64x4>(()), expect);
    }
}

/// Every operation on eight numbers once.
struct ChainOfEight([[f32; EIGHT]; 3]);

impl Kernel for ChainOfEight {
    type Output = ([f32; EIGHT], f32);

    #[inline(always)]
    fn run<L: Lanes>(self, machine: L::Machine) -> Self::Output {
        let [a, b, c] = self.0.map(|v| L::Eight::load(machine, &v));
        let mut sum = a * b + c;
        sum += a.or_lesser(b) - c;
        let whole = (L::Eight::splat(machine, 12_582_912.0) + c).two_to_whole();
        let found = sum * whole;
        (found.to_array(), total_of_eight(found))
    }
}

proptest! {
    #[test]
    fn eight_numbers_give_the_bits_of_one_by_one(numbers in prop::array::uniform3(prop::array::uniform8(-20.0..20.0_f32))) {
        let [a, b, c] = numbers;
        let lane = |at: usize| {
            let mut sum = a[at] * b[at] + c[at];
            sum += a[at].min(b[at]) - c[at];
            sum * libm::exp2f(c[at].round_ties_even())
        };
        let found: [f32; EIGHT] = std::array::from_fn(lane);
        let [a, b, c, d, e, f, g, h] = found;
        let total = ((a + e) + (c + g)) + ((b + f) + (d + h));
        let expect = (found.map(f32::to_bits), total.to_bits());
        let bits = |(found, total): ([f32; EIGHT], f32)| (found.map(f32::to_bits), total.to_bits());
        prop_assert_eq!(bits(run(ChainOfEight(numbers))), expect);
        prop_assert_eq!(bits(ChainOfEight(numbers).run::<f64x4>(())), expect);
    }
}

#[test]
fn lanes_come_together_in_one_order() {
    let lanes = f64x4::new([1e16, 1.0, -1e16, 3.0]);
    // (1e16 + 1) + (-1e16 + 3), rounded at each step.
    assert_eq!(total(lanes), (1e16 + 1.0) + (-1e16 + 3.0));
    assert_eq!((greatest(lanes), least(lanes)), (1e16, -1e16));
}

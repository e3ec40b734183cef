# The errors of the numbers that the filter in f32 starts from are within what its two other proofs assume.
#@ src/caster/filter.rs MAX_DEPTH = 2.03125
#
# The names are those of filter_portable.g. a, o and d are a coordinate of the corner, of the origin and of the
# direction in f64; at, ot and dt are the exact ones. The origin, (o - center + entry direction) scale, has two
# roundings of numbers up to 2^20, since rays from farther away are not tested by the filter, and it lies outside the
# box by no more than the rounding of entry. 2^-31 is more than either.

@f32 = float<ieee_32, ne>;
MAX_DEPTH = 2.03125;

af = f32(a);
of = f32(o);
df = f32(d);
sf = f32(af - of);
s = at - ot;

# One component of q. Its first product is rounded only in the portable kernel.
product = f32(df * sf);
other = f32(ef * tf);

{
  |a| <= 1 /\ |at - a| <= 1b-52 /\ |o| <= 0x1.00000008p0 /\ |ot - o| <= 1b-31 /\ |ot| <= 0x1.00000008p0 /\
  |at| <= 0x1.00000008p0 /\ |d| <= 1 /\ |dt - d| <= 1b-52 /\ |ef| <= 1 /\ |tf| <= 2 /\
  far64 / MAX_DEPTH in [-1, 1] /\ |far - far64| <= 1b-50
->
  |sf| <= 2 /\
  |s| <= 0x1.00000008p1 /\
  |sf - s| <= 132096b-40 /\
  |df| <= 1 /\
  |df - dt| <= 33792b-40 /\
  |product - df * sf| <= 1b-24 /\
  |(product - df * sf) - (other - ef * tf)| <= 2b-24 /\
  |f32(far64) - far| <= 0x2.0004p-24
}

sf - s -> (sf - (af - of)) + ((af - a) - (of - o)) + ((a - at) - (o - ot));
$ o in (-1, 1);

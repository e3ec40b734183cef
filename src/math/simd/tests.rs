mod f64x4;
mod lanes;
mod exp;

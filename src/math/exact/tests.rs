mod scaled;
mod exact_sum;
mod predicate;

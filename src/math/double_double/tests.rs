mod exact_product;
mod double_double;

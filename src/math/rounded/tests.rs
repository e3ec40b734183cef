mod rounded_affine;

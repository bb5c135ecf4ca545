// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>

#include "common/image/image.h"
#include "reconstructor/irradiance_field_file/field_terms.h"

namespace sheen {

/// The terms of all images but those that are fainter than `least_rms` grey levels. `gram` becomes the images' products
/// with each other, n x n, summed over pixels and colours. Images: 3 channels, all of one size.
FieldTerms find_terms(std::span<const ImageF> images, double least_rms, Eigen::MatrixXd& gram);

}  // namespace sheen

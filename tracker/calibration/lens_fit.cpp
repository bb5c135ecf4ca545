// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/lens_fit.h"

namespace sheen {
namespace {

constexpr std::array kFits = {
    LensFit{"pinhole", "f cx cy", LensModel::kOpenCv, {true, false, true, true}},
    LensFit{"radial", "f cx cy k1 k2", LensModel::kOpenCv, {true, false, true, true, true, true}},
    LensFit{"brown", "f cx cy k1 k2 p1 p2", LensModel::kOpenCv, {true, false, true, true, true, true, true, true}},
    LensFit{"brown-k3",
            "f cx cy k1 k2 p1 p2 k3",
            LensModel::kOpenCv,
            {true, false, true, true, true, true, true, true, true}},
    LensFit{"brown-k3-aspect",
            "fx fy cx cy k1 k2 p1 p2 k3",
            LensModel::kOpenCv,
            {true, true, true, true, true, true, true, true, true}},
    LensFit{"fisheye", "f cx cy k1 k2 k3 k4", LensModel::kFisheye, {true, false, true, true, true, true, true, true}},
};

}  // namespace

std::span<const LensFit> lens_fits() {
  return kFits;
}

const LensFit* find_lens_fit(const std::string& name) {
  for (const LensFit& fit : kFits)
    if (name == fit.name) return &fit;
  return nullptr;
}

}  // namespace sheen

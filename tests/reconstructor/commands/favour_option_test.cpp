// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/favour_option.h"

#include <gtest/gtest.h>

#include "reconstructor/commands/limit_options.h"
#include "reconstructor/commands/size_options.h"
#include "reconstructor/models/surface_light_field/surface_light_field_options.h"

namespace sheen {
namespace {

struct Filled {
  LimitArguments limits;
  SizeArguments size;
};
Filled filled(const std::string& word, Filled given = {}) {
  SurfaceLightFieldOptions settings;
  FavourArgument{word}.fill(given.limits, given.size, settings);
  return given;
}

/// What `--loss` may cost in pictures, and a tolerance in error.
double loss_db(const Filled& f) {
  return std::stod(f.size.loss);
}
double tolerance(const Filled& f) {
  return std::stod(f.limits.tolerance);
}

TEST(Favour, EachWordLeansItsWay) {
  const Filled speed = filled("speed"), accuracy = filled("accuracy"), size = filled("size");
  EXPECT_NE(speed.limits.budget, "");
  EXPECT_EQ(accuracy.limits.budget, "") << "nothing is hurried";
  const double usual = SurfaceLightFieldOptions{}.patch.factor.tolerance;
  EXPECT_GT(tolerance(speed), usual);
  EXPECT_LT(tolerance(accuracy), usual);
  EXPECT_GT(tolerance(size), usual);
  const double usual_loss = CompressionTarget{}.loss_db;
  EXPECT_LT(loss_db(accuracy), usual_loss);
  EXPECT_GT(loss_db(size), usual_loss);
  for (const Filled& each : {speed, accuracy, size}) {
    SurfaceLightFieldOptions settings;
    EXPECT_NO_THROW(each.limits.apply(settings));
    EXPECT_EQ(settings.patch.factor.tolerance, tolerance(each));
  }
}

TEST(Favour, WhatIsGivenStays) {
  const Filled own = filled("speed", {.limits = {.budget = "20ms", .tolerance = "0.1"}, .size = {.loss = "1dB"}});
  EXPECT_EQ(own.limits.budget, "20ms");
  EXPECT_EQ(own.limits.tolerance, "0.1");
  EXPECT_EQ(own.size.loss, "1dB");
  EXPECT_EQ(filled("size", {.size = {.bytes = "1MB"}}).size.loss, "") << "both would contradict each other";
  EXPECT_EQ(filled("accuracy", {.limits = {.target = "35dB"}}).limits.tolerance, "") << "the target sets it";
}

TEST(Favour, NoWordSetsNothing) {
  const Filled nothing = filled("");
  EXPECT_EQ(nothing.limits.budget + nothing.limits.tolerance + nothing.size.loss, "");
}

}  // namespace
}  // namespace sheen

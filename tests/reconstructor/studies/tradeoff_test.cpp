// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/studies/tradeoff.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "tests/support/expect_error.h"

namespace sheen {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TradeoffPoint point(double ms, double bytes, double psnr) {
  return {.image_ms = ms, .bytes = bytes, .psnr_db = psnr};
}

TEST(Frontier, KeepsWhatNoOtherPointBeats) {
  //                                 0   1   2   3   4
  const std::vector<double> cost = {10, 20, 30, 15, 20};
  const std::vector<double> worth = {25, 30, 29, 25, 28};
  EXPECT_THAT(pareto_frontier(cost, worth), ElementsAre(0, 1));
}

TEST(Frontier, RunsFromCheapToDear) {
  const std::vector<double> cost = {3, 1, 2}, worth = {3, 1, 2};
  EXPECT_THAT(pareto_frontier(cost, worth), ElementsAre(1, 2, 0));
}

TEST(Frontier, OfEqualPointsTheFirstStands) {
  const std::vector<double> cost = {1, 1, 1}, worth = {5, 6, 6};
  EXPECT_THAT(pareto_frontier(cost, worth), ElementsAre(1));
}

TEST(Frontier, LeavesOutWhatIsNoNumber) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  const std::vector<double> cost = {nan, 1, inf, 2}, worth = {9, nan, 9, 1};
  EXPECT_THAT(pareto_frontier(cost, worth), ElementsAre(3));
  EXPECT_THAT(pareto_frontier({}, {}), IsEmpty());
}

const std::vector<TradeoffPoint> kPoints = {point(10, 100, 25), point(30, 300, 28), point(60, 200, 29),
                                            point(90, 900, 30)};

TEST(Choice, TheBestWithinTheLimits) {
  EXPECT_EQ(choose_setting(kPoints, {.image_ms = 33}).index, 1u);
  EXPECT_EQ(choose_setting(kPoints, {.bytes = 250}).index, 2u);
  EXPECT_EQ(choose_setting(kPoints, {.image_ms = 33, .bytes = 250}).index, 0u);
  EXPECT_EQ(choose_setting(kPoints, {}).index, 3u);
  EXPECT_TRUE(choose_setting(kPoints, {.image_ms = 30}).holds);
}

TEST(Choice, TheQuickestThatReachesTheTarget) {
  EXPECT_EQ(choose_setting(kPoints, {.psnr_db = 27}).index, 1u);
  EXPECT_EQ(choose_setting(kPoints, {.bytes = 250, .psnr_db = 27}).index, 2u);
  EXPECT_TRUE(choose_setting(kPoints, {.bytes = 250, .psnr_db = 27}).holds);
}

TEST(Choice, WhatCannotBeHadIsSaid) {
  const TradeoffChoice too_much = choose_setting(kPoints, {.psnr_db = 35});
  EXPECT_EQ(too_much.index, 3u);
  EXPECT_FALSE(too_much.holds);
  const TradeoffChoice too_tight = choose_setting(kPoints, {.image_ms = 5});
  EXPECT_EQ(too_tight.index, 0u);
  EXPECT_FALSE(too_tight.holds);
  const TradeoffChoice both = choose_setting(kPoints, {.image_ms = 33, .psnr_db = 29});
  EXPECT_EQ(both.index, 1u) << "limits come first";
  EXPECT_FALSE(both.holds);
}

TEST(Limits, WordsAreRead) {
  const Limits limits = parse_limits("33ms", "35dB", "1.5 GB");
  EXPECT_EQ(limits.image_ms, 33);
  EXPECT_EQ(limits.psnr_db, 35);
  EXPECT_EQ(limits.bytes, 1.5e9);
  EXPECT_EQ(parse_limits("0.2s", "", "1MiB").image_ms, 200);
  EXPECT_EQ(parse_limits("0.2s", "", "1MiB").bytes, 1048576);
  EXPECT_TRUE(parse_limits("", "", "").empty());
  EXPECT_EQ(describe(limits), "at most 33 ms per image, at most 1500 MB, at least 35 dB");
}

TEST(Limits, NonsenseIsRefusedByName) {
  expect_error<ConfigError>([] { parse_limits("33", "", ""); }, {"--budget 33", "33ms"});
  expect_error<ConfigError>([] { parse_limits("-5ms", "", ""); }, {"--budget -5ms"});
  expect_error<ConfigError>([] { parse_limits("", "high", ""); }, {"--target high", "35dB"});
  expect_error<ConfigError>([] { parse_limits("", "", "1GBB"); }, {"--memory 1GBB", "1GB"});
  expect_error<ConfigError>([] { parse_limits("", "", "infGB"); }, {"--memory"});
  expect_error<ConfigError>([] { parse_limits("nanms", "", ""); }, {"--budget"});
}

TEST(TradeoffSettings, EachIsDifferentAndNamed) {
  for (const bool quick : {false, true}) {
    const std::vector<Setting> settings = tradeoff_settings({}, quick);
    std::set<std::string> names;
    for (const Setting& setting : settings) {
      EXPECT_TRUE(names.insert(setting.name).second) << setting.name;
      EXPECT_FALSE(setting.part.empty());
    }
    EXPECT_EQ(settings.front().part, "default");
  }
  std::set<std::string> parts;
  for (const Setting& setting : tradeoff_settings({}, true)) parts.insert(setting.part);
  EXPECT_EQ(parts, (std::set<std::string>{"default", "rank", "internal rank", "tolerance", "surface map", "sampling",
                                          "block", "views", "repetitions", "imputation", "rank and map"}));
  EXPECT_LT(2 * tradeoff_settings({}, true).size(), 1.4 * tradeoff_settings({}, false).size());
}

TEST(Parts, EachIsTheBaseWithSomethingElseInOnePlace) {
  SurfaceLightFieldOptions base;
  base.patch.factor.max_rank = 9;
  base.patch.factor.internal_rank = 20;
  const std::vector<Setting> settings = part_settings(base);
  std::set<std::string> names, ways;
  for (const Setting& setting : settings) {
    names.insert(setting.name);
    const auto& o = setting.options;
    EXPECT_EQ(o.patch.factor.max_rank, 9) << setting.name;
    char way[160];
    std::snprintf(way, sizeof way, "%d %d %d %d %g %d %d %d", static_cast<int>(o.patch.interpolation.method),
                  o.patch.interpolation.drift, o.patch.interpolation.exponential,
                  static_cast<int>(o.patch.factor.imputation), o.patch.min_visible, static_cast<int>(o.sampling),
                  o.visibility.erosion_px, o.patch.factor.internal_rank);
    ways.insert(way);
  }
  EXPECT_EQ(names.size(), settings.size());
  EXPECT_EQ(ways.size(), settings.size()) << "no two are the same";
  EXPECT_EQ(settings.front().options.patch.interpolation.method, ViewMethod::kKriging);
  EXPECT_EQ(settings.front().options.patch.factor.imputation, Imputation::kMostProbable);
}

}  // namespace
}  // namespace sheen

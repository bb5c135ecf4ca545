// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/relighting_bound.h"

#include <tbb/parallel_for.h>

#include <array>
#include <chrono>
#include <limits>
#include <memory>

#include "reconstructor/numerics/light_spacing.h"
#include "tests/support/light_elements.h"

namespace sheen {
namespace {

constexpr double kGreyLevels = 16;
constexpr std::int64_t kElements = 10'000'000, kParts = 16;
constexpr int kSearches = 5;  // of which the best counts: other programs take their time, too

struct Surface {
  std::string name;
  PlainReflectance plain;
  std::shared_ptr<const Reflectance> reflectance;
};

/// Largest error of lit elements, in units of exposure.
double worst_error(const Surface& surface, double spacing, bool far, std::int64_t elements) {
  std::array<double, kParts> worst{};
  tbb::parallel_for(std::int64_t{0}, kParts, [&](std::int64_t i) {
    worst[static_cast<std::size_t>(i)] =
        LitElements(surface.plain, spacing, far, static_cast<std::uint64_t>(i) + 1).worst(elements / kParts).lit;
  });
  return *std::max_element(worst.begin(), worst.end());
}

}  // namespace

void report_bound(GoalReport& report) {
  const std::array surfaces{
      Surface{"matt", plain_lobe(0), std::make_shared<FreeLobes>(std::vector<ReflectanceLobe>{{}})},
      Surface{"lobe of exponent 50", plain_lobe(50),
              std::make_shared<FreeLobes>(std::vector<ReflectanceLobe>{{.exponent = 50}})},
      Surface{"microfacets, roughness 0.3", plain_microfacets(0.4, 0.05, 0.3),
              std::make_shared<AnalyticReflectance>(
                  std::vector<AnalyticReflectance::Lafortune>{{.weight = 0.4}},
                  std::vector<AnalyticReflectance::Microfacets>{{.normal_reflectance = 0.05, .roughness = 0.3}})}};
  for (const Surface& surface : surfaces) {
    ExposureBounds bounds;
    double ms = std::numeric_limits<double>::infinity();
    for (int i = 0; i < kSearches; ++i) {
      const auto begin = std::chrono::steady_clock::now();
      bounds = search_bounds(*surface.reflectance);
      ms = std::min(ms, std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count());
    }
    report.add(at_most(100, {}, "search over normals, the best of 5, " + surface.name, ms, "ms"));
    for (const bool far : {false, true}) {
      const LightSpacing spacing =
          far ? plan_direction_spacing(bounds, kGreyLevels / 255) : plan_spacing(bounds, 1, kGreyLevels / 255);
      const double level = bounds.brightest / 255;
      const std::string name = surface.name + (far ? ", far lights" : ", near lights");
      const double twice = worst_error(surface, 2 * spacing.on_grid, far, kElements / 10) / level;
      report.add(at_most(kGreyLevels, {}, "worst of 10^7 lit elements at the planned spacing, " + name,
                         worst_error(surface, spacing.on_grid, far, kElements) / level, "grey levels",
                         {{"at twice the spacing", twice}}));
    }
  }
}

}  // namespace sheen

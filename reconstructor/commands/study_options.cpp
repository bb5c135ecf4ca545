// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/study_options.h"

#include "common/base/command_line.h"

namespace sheen {

void StudyOptions::apply(SurfaceLightFieldOptions& options) const {
  set(options, "interpolation", interpolation);
  set(options, "imputation", imputation);
  set(options, "visibility", visibility);
}

void add_study_options(Command& command, StudyOptions& options) {
  command
      .option("--interpolation", options.interpolation,
              "interpolation between views: kriging, or delaunay as in the paper")
      .check(one_of({"kriging", "delaunay"}))
      .group("Studies");
  command
      .option("--imputation", options.imputation,
              "imputation of what images do not show: most-probable, or least-squares with gates as in the paper")
      .check(one_of({"most-probable", "least-squares"}))
      .group("Studies");
  command
      .option("--visibility", options.visibility,
              "what decides whether an image shows a sample: samples, or the triangle's vertices as in the paper")
      .check(one_of({"samples", "vertices"}))
      .group("Studies");
}

}  // namespace sheen

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "reconstructor/models/surface_light_field/surface_light_field_options.h"

namespace sheen {

class Command;

/// The ways in which a model departs most from the paper, selectable to compare with the paper's own.
struct StudyOptions {
  std::string interpolation = "kriging", imputation = "most-probable", visibility = "samples";

  void apply(SurfaceLightFieldOptions& options) const;
};

/// --interpolation, --imputation and --visibility, in a group of their own.
void add_study_options(Command& command, StudyOptions& options);

}  // namespace sheen

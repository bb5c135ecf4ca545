// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

namespace sheen {

/// A reader of Prometheus' text format 0.0.4, written from its description and not from our writer: strict about names,
/// escapes, the order of # HELP, # TYPE and samples, samples that stand there twice, and the final newline.
struct ExpositionSample {
  std::string name;
  std::map<std::string, std::string> labels;
  double value = 0;
};
struct Exposition {
  std::map<std::string, std::string> types;  ///< by family
  std::vector<ExpositionSample> samples;

  /// NaN when there is no such sample.
  double value(const std::string& name, const std::map<std::string, std::string>& labels = {}) const;
};
Exposition parse_exposition(const std::string& text);  ///< throws std::exception

}  // namespace sheen

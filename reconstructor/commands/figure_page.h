// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "common/base/report_file.h"
#include "reconstructor/studies/figure.h"

namespace sheen {

using Figures = std::map<int, std::function<Figure()>>;  ///< by their number in the paper

/// A page of a paper's experiments: a section for each figure, its plots, tables and pictures in OUT/images, and a
/// report of what was found.
class FigurePage {
 public:
  /// `name`: of the page, in `out`. `only`: numbers of those that are wanted; empty: all. `json`: as for `ReportFile`.
  /// Throws FileError where nothing can be written.
  FigurePage(const std::filesystem::path& out, const std::string& name, std::vector<int> only, const std::string& json);

  /// Makes those that are wanted, one after the other; a stop signal ends it, and finished ones are kept. `heading`:
  /// what the page begins with.
  void make(const Figures& all, std::string heading);

 private:
  bool wanted(int number) const;
  /// A section of the page; its plots, tables and pictures are written.
  std::string publish(const Figure& figure);

  std::filesystem::path out_;
  std::string name_;
  std::vector<int> only_;
  ReportFile report_;
  bool drawn_ = true;  ///< all plots, by gnuplot
};

}  // namespace sheen

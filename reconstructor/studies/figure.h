// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/image/image.h"
#include "common/plot/plot.h"
#include "reconstructor/studies/batch_light_field.h"
#include "reconstructor/studies/experiment.h"

namespace sheen {

/// One of the papers' experiments, run again.
struct Figure {
  int number = 0;  ///< in the paper
  std::string title;
  std::string paper;  ///< what the paper reports
  std::string ours;   ///< what was measured, in figures
  bool holds = true;  ///< whether it supports the paper's claim, or Sheen's own goal where that is stricter

  struct NamedPlot {
    std::string file;  ///< without a suffix
    Plot plot;
  };
  std::vector<NamedPlot> plots;
  struct Picture {
    std::string file, caption;
    ImageU8 image;
  };
  std::vector<Picture> pictures;
  struct Table {
    std::string file, caption;  ///< the file without a suffix
    std::vector<std::string> columns;
    std::vector<std::vector<std::string>> rows;
  };
  std::vector<Table> tables;
};

/// Pictures one beside the other, row by row; all of one size, of 3 channels or of 1.
ImageU8 mosaic(const std::vector<std::vector<ImageU8>>& rows);

std::string table_csv(const Figure::Table& table);
std::string table_markdown(const Figure::Table& table);

struct FigureOptions {
  SurfaceLightFieldOptions model;  ///< of every light field; rank is `rank`
  int rank = 6;                    ///< terms displayed: the paper's
  std::uint64_t seed = 1;          ///< of random orders and choices
  bool quick = false;              ///< fewer orders, ranks and counts
};

/// Mean PSNR of the object's pixels over views: what `score` calls psnr_db, without the rest.
double mean_psnr_db(const std::vector<HeldOutView>& views, const Appearance& model, const RayPainter& painter);

/// A batch light field of all training images, and what it took.
struct BatchRun {
  std::unique_ptr<BatchLightField> columns;
  std::shared_ptr<const SurfaceLightFieldSnapshot> model;
  double collect_s = 0;    ///< wall time of seeing and resampling all images
  double factorize_s = 0;  ///< wall time from the last image to the model
  double cpu_s = 0;        ///< processor time of both, all threads
  double psnr_db = 0;      ///< of the held-out views
};
BatchRun build_batch(const Experiment& experiment, const FigureOptions& options, const BatchFactorization& how);

/// Figure 4: error of patches against rank; online at that rank, online at twice that rank inside, and PCA.
Figure figure_rank_error(const BatchRun& batch, const FigureOptions& options);

/// Figure 5: missing values imputed or not.
Figure figure_imputation(const Experiment& experiment, const FigureOptions& options);

/// Figure 8: pictures of the online and of the batch light field, from held-out views and from ten random ones.
Figure figure_online_and_batch(const Experiment& experiment, const BatchRun& batch, const FigureOptions& options);

/// Figure 9: time to a finished model for each mesh, with the same images.
struct NamedMesh {
  std::string name;
  std::shared_ptr<const Mesh> mesh;
};
Figure figure_time(const Experiment& experiment, const std::vector<NamedMesh>& meshes, const FigureOptions& options);

/// Figure 10: convergence with images chosen by the guidance, by the red and by the paper's heuristic (added up alike),
/// at random, and farthest from those already chosen. It holds when the guidance needs at most three quarters of the
/// images for what the farthest view makes of all.
Figure figure_view_choice(const Experiment& experiment, const FigureOptions& options);

/// Images at which a curve first has `y`, by linear interpolation; NaN where it never does.
double images_to_reach(const PlotSeries& curve, double y);

/// Figure 11: random orders of the images, orders sorted by their norm, and PCA.
Figure figure_orders(const Experiment& experiment, const BatchRun& batch, const FigureOptions& options);

}  // namespace sheen

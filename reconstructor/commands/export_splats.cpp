// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <nlohmann/json.hpp>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/json_number.h"
#include "common/base/progress.h"
#include "common/base/stop_signal.h"
#include "reconstructor/commands/exports.h"
#include "reconstructor/splats/splat_file.h"
#include "reconstructor/splats/splat_fit.h"

namespace sheen {
namespace {

constexpr std::size_t kBytes = 4'990'000;  ///< of the splats: with the header, less than 5 MB

}  // namespace

nlohmann::json export_splats(const ModelSnapshot& model, const std::string& name, const std::filesystem::path& out) {
  check_writable(out);
  const std::shared_ptr<const ModelSnapshot> filled = model.filled();
  const std::optional<AverageLook> look = filled->average_look();
  if (!look) throw ConfigError(name + ": has no surface that is seen from all sides, so there is none for --splats");
  const StepsDone bar = progress_bar("fitting");
  const FittedSplats fitted =
      fit_splats({*filled, *look->shader, model.cameras()}, kBytes / splat_bytes(kMostSplatDegree), kMostSplatDegree,
                 [&](std::size_t done, std::size_t steps) {
                   if (stop_requested()) throw Error("stopped before it was exported");
                   bar(done, steps);
                 });
  write_splats(out, fitted.splats, model.mesh().origin);
  std::printf("%s written: %zu Gaussians, which show the model from between its images with %.2f dB\n", out.c_str(),
              fitted.splats.shapes.size(), fitted.psnr_db);
  return {{"path", out.string()},
          {"bytes", std::filesystem::file_size(out)},
          {"splats", fitted.splats.shapes.size()},
          {"degree", kMostSplatDegree},
          {"psnr_db", json_number(fitted.psnr_db)}};
}

}  // namespace sheen

// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/base/command_line.h"
#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/progress.h"
#include "common/base/report_file.h"
#include "reconstructor/capture/saved_model.h"
#include "reconstructor/commands/commands.h"
#include "reconstructor/commands/size_options.h"

namespace sheen {
namespace {

struct CompressArguments {
  std::string model, out, json;
  SizeArguments size;
};

void compress(const CompressArguments& arguments) {
  ReportFile json(arguments.json);
  check_writable(arguments.out);
  SavedModel saved = open_model(arguments.model);
  std::optional<CompressionTarget> target = arguments.size.target(*saved.kind);
  if (!target)
    throw ConfigError(arguments.model +
                      ": nothing to compress: --loss is 0dB, or models of this kind have no smaller form");
  target->psnr_db = held_out_psnr_db(saved);
  target->progress = progress_bar("compressing");
  std::unique_ptr<Compression> compression = saved.snapshot->compression(*std::move(target));
  saved.snapshot.reset();
  const CompressedModel small = compression->run();
  compression.reset();  // takes the bar away
  small.snapshot->save(arguments.out, saved.metadata, {});
  const auto bytes = std::filesystem::file_size(arguments.out);
  std::printf("%s: %.3f MB, about %.2f dB lost\n", arguments.out.c_str(), static_cast<double>(bytes) / 1e6,
              small.loss_db);
  json.write(nlohmann::json{{"file", {{"bytes", bytes}, {"loss_db", small.loss_db}}}}.dump(2) + "\n");
}

}  // namespace

void add_compress_command(Command& program) {
  auto arguments = std::make_shared<CompressArguments>();
  Command command = program.subcommand("compress", "Writes a saved model as one small file (default: --loss 0.1dB).");
  command.option("model", arguments->model, "folder of a saved model").required();
  command.option("--out", arguments->out, "file to write").required();
  arguments->size.add_to(command);
  command.option("--json", arguments->json, "report to write; - for standard output");
  command.callback([arguments] { compress(*arguments); });
}

}  // namespace sheen

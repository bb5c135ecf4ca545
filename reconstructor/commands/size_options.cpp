// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/size_options.h"

#include "common/base/command_line.h"
#include "common/base/errors.h"
#include "common/base/quantity.h"

namespace sheen {

void SizeArguments::add_to(Command& command, const std::string& without_loss) {
  const Option by_bytes = command.option(
      "--bytes", bytes, "size that the file may have, such as 2MB (kB, MB, GB, KiB, MiB, GiB) or 2000000");
  command.option("--loss", loss, "PSNR that the pictures may lose (default: 0.1dB)" + without_loss)
      .excludes({by_bytes});
}

std::optional<CompressionTarget> SizeArguments::target(const ModelKind& kind, const ModelSettings& settings) const {
  const std::optional<CompressionTarget> asked = target(kind);
  if (const std::string why = settings.no_small_form(); asked && !why.empty())
    throw ConfigError(why + ": --loss 0dB saves such a model as it is");
  return asked;
}

std::optional<CompressionTarget> SizeArguments::target(const ModelKind& kind) const {
  CompressionTarget target;
  if (!bytes.empty()) target.bytes = parse_bytes("--bytes", bytes, "the size that the file may have, such as 2MB");
  if (!loss.empty())
    target.loss_db = parse_decibels("--loss", loss, "the PSNR that the pictures may lose, such as 0.1dB");
  if (kind.compresses()) return target.loss_db > 0 ? std::optional(target) : std::nullopt;
  if (!bytes.empty()) throw ConfigError(std::string("--bytes: a ") + kind.title() + " has no smaller form");
  return std::nullopt;
}

}  // namespace sheen

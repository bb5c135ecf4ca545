// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/serve_end.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <utility>

#include "common/base/errors.h"
#include "common/base/log.h"
#include "common/base/progress.h"
#include "common/base/stop_signal.h"
#include "reconstructor/capture/saved_model.h"
#include "reconstructor/commands/serve_watch.h"

namespace sheen {
namespace {

constexpr std::chrono::milliseconds kEarlyEndPatience{700};

/// A bar per stage on the terminal, also while it is not known how much there is to do.
class EndBar {
 public:
  void show(const EndProgress& end) {
    if (end.stage == EndStage::kCapturing) return;
    if (end.stage != shown_ || end.total != total_ || !bar_) {
      bar_.reset();  // takes its line away before the next one draws
      bar_.emplace(name_of(end.stage), end.total);
    }
    shown_ = end.stage;
    total_ = end.total;
    bar_->update(end.done);
  }

 private:
  static const char* name_of(EndStage stage) {
    switch (stage) {
      case EndStage::kRefining:
        return "refining";
      case EndStage::kSaving:
        return "saving";
      case EndStage::kJudging:
        return "judging";
      case EndStage::kCapturing:
      case EndStage::kFinishing:
        break;
    }
    return "finishing";
  }

  EndStage shown_ = EndStage::kCapturing;
  std::uint64_t total_ = 0;
  std::optional<Progress> bar_;
};

/// Nothing is lost by an end without the model.
std::string words_of_an_early_end(const EarlyEnd& early, const LoopStatus& status, EndStage stage) {
  if (stage == EndStage::kJudging)
    return "ended before the report was made; the model is saved in " + early.session + "/" + kSessionModel;
  return "ended before the model was finished; nothing is lost: " + std::to_string(status.journaled) +
         " captures are kept in " + early.session + ". The same command continues with them; `" + early.build_command +
         "` builds their model";
}

}  // namespace

CaptureEnd::Result end_capture(CaptureLoop& loop, CaptureEnd& end, ViewerWindow*& window, const ViewerFeed& feed,
                               const EarlyEnd& early) {
  const int signals = std::min(stop_signals(), 1);  // the one that brought us here
  if (const LoopStatus status = loop.status(); status.error.empty() && status.journaled > 0)
    log_info(
        "session",
        "finishing: waiting images are added to the model, then the model is saved; Ctrl-C once more, or Q, ends it "
        "now without the model",
        {{"captures", status.journaled}, {"waiting", status.waiting()}});
  end.begin();
  {
    EndBar bar;
    wait_until(
        [&] {
          bar.show(end.progress());
          return end.over() || stop_signals() > signals;
        },
        window, feed);
  }
  if (!end.over() && !end.stop(kEarlyEndPatience)) {
    std::fprintf(stderr, "sheen-reconstructor: %s\n",
                 words_of_an_early_end(early, loop.status(), end.progress().stage).c_str());
    stop_logging();
    std::_Exit(1);  // the journal is durable, and the next save removes what this one leaves
  }
  if (std::optional<CaptureEnd::Result> result = end.result()) return *std::move(result);
  throw Error(words_of_an_early_end(early, loop.status(), end.progress().stage));
}

}  // namespace sheen

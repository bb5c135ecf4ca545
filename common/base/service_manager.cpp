// SPDX-License-Identifier: Apache-2.0
#include "common/base/service_manager.h"

#include <systemd/sd-daemon.h>

namespace sheen {

void tell_service_is_ready() {
  sd_notify(0, "READY=1");
}

void tell_service_is_stopping() {
  sd_notify(0, "STOPPING=1");
}

}  // namespace sheen

// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sheen {

/// Tells systemd that a service (Type=notify) is ready, so that what waits for it may start; nothing where no manager
/// asked for it (sd_notify, $NOTIFY_SOCKET).
void tell_service_is_ready();
/// The same of its end, which may take its time.
void tell_service_is_stopping();

}  // namespace sheen

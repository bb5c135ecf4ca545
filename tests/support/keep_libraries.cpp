// SPDX-License-Identifier: Apache-2.0
// Preloaded where leaks are looked for: libraries stay loaded until the process ends, so that a report can say whose a
// leak is. OpenGL drivers are unloaded with their context, and what they keep would belong to nobody.
extern "C" int dlclose(void*) {
  return 0;
}

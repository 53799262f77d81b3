// SPDX-License-Identifier: MIT
// The libFuzzer program of all entries: `fuzz_readers ENTRY [options] CORPUS` looks for inputs,
// `fuzz_readers ENTRY FILE` repeats one, `fuzz_readers --seeds ENTRY FOLDER` writes the seeds. See run.
#include <tbb/global_control.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>

#include "entries.h"

namespace {

using gyrobudget::fuzz::Entry;

const Entry* entry = nullptr;

const Entry* find(const char* name) {
  const auto& all = gyrobudget::fuzz::entries();
  const auto at = std::ranges::find(all, name, &Entry::name);
  if (at != all.end()) return &*at;
  for (const Entry& one : all) std::printf("%s\n", one.name.c_str());
  std::exit(2);
}

void write_seeds(const std::string& folder) {
  for (std::size_t i = 0; i < entry->seeds.size(); ++i)
    std::ofstream(folder + "/seed-" + std::to_string(i), std::ios::binary) << entry->seeds[i];
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  const bool seeds = *argc == 4 && std::string((*argv)[1]) == "--seeds";
  static const tbb::global_control kOneThread(tbb::global_control::max_allowed_parallelism, 1);  // others would spin
  entry = find(*argc > 1 ? (*argv)[seeds ? 2 : 1] : "");
  if (seeds) {
    write_seeds((*argv)[3]);
    std::exit(0);
  }
  (*argv)[1] = (*argv)[0];  // the name is none of libFuzzer's words
  ++*argv;
  --*argc;
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  entry->run({reinterpret_cast<const char*>(data), size});
  return 0;
}

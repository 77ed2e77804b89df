// SPDX-License-Identifier: BSD-3-Clause
// make_synthetic_results DIR [--leaking] [--dry] [--no-chordae]: a made-up RESULTS/ with its report, for looking at and for the
// browser test.
#include <iostream>
#include <string>

#include "solver/report/report.h"
#include "support/synthetic_results.h"

int main(int argc, char** argv) {
  if (argc < 2) {
    std::cerr << "usage: make_synthetic_results DIR [--leaking] [--dry] [--no-chordae]\n";
    return 2;
  }
  mv::test::SyntheticOptions options;
  for (int i = 2; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--leaking") options.is_sealed = false;
    if (argument == "--dry") options.has_fluid = false;
    if (argument == "--no-chordae") options.has_chordae = false;
  }
  try {
    mv::test::write_synthetic_results(argv[1], options);
    std::cout << mv::write_report(argv[1]).string() << "\n";
  } catch (const std::exception& e) {
    std::cerr << e.what() << "\n";
    return 1;
  }
  return 0;
}

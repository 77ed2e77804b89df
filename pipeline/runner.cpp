// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/runner.h"

#include <algorithm>
#include <chrono>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"
#include "geometry/core/log.h"
#include "pipeline/case_directory.h"
#include "pipeline/interrupt.h"
#include "pipeline/stage_table.h"

namespace mv {
namespace {

constexpr const char* quality_file = "quality.json";

void remove_outputs(const Stage& stage, const std::filesystem::path& case_directory) {
  std::error_code ignored;
  for (const std::string& file : stage.outputs) std::filesystem::remove(case_directory / file, ignored);
}

/// Records of later stages that complete a file this stage has just begun anew.
void forget_completions(const Stage& stage, Manifest& manifest) {
  bool is_later = false;
  for (const Stage& other : stage_table()) {
    const bool shares = std::any_of(other.outputs.begin(), other.outputs.end(), [&](const std::string& file) {
      return std::find(stage.outputs.begin(), stage.outputs.end(), file) != stage.outputs.end();
    });
    if (is_later && shares) manifest.stages.erase(other.name);
    is_later = is_later || other.name == stage.name;
  }
}

/// Runs the stage in a directory of its own and takes its files into the case. Without `is_repeatable` the record says that it
/// can never be skipped.
void execute(const Stage& stage, const Config& config, const std::filesystem::path& case_directory, Manifest& manifest,
             const OnStage& on_stage, bool is_repeatable = true) {
  spdlog::debug("stage {}: {}", stage.name, stage.help);
  const auto start = std::chrono::steady_clock::now();
  StageDirectory work(case_directory, stage.name);
  StageRecord record;
  if (is_repeatable) record.key = stage_key(stage, config, manifest);
  std::string result;
  try {
    result = stage.run({config, case_directory, work.path()});
  } catch (const GateError&) {
    if (std::filesystem::exists(work.path() / quality_file)) work.publish({quality_file});  // the verdict is the result
    throw;
  } catch (const InputError& e) {
    throw InputError(with_sources(e.what(), case_directory));
  } catch (const IoError& e) {
    throw IoError(with_sources(e.what(), case_directory));
  } catch (const ConfigError& e) {
    throw ConfigError(with_sources(e.what(), case_directory));
  }
  const Uninterrupted writes;
  record.outputs = work.publish(stage.outputs);
  forget_completions(stage, manifest);
  manifest.stages[stage.name] = record;
  write_manifest(case_directory, manifest, config);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  on_stage({stage.name, false, seconds, result});
}

}  // namespace

void run_all_stages(const Config& config, const std::filesystem::path& case_directory, Manifest manifest,
                    const std::optional<std::string>& from, const OnStage& on_stage) {
  if (from) find_stage(*from);
  bool is_forced = false;
  for (const Stage& stage : stage_table()) {
    is_forced = is_forced || (from && stage.name == *from);
    for (const std::string& file : changed_outputs(stage, manifest, case_directory)) {
      spdlog::warn("{} was changed since mvprep wrote it; stage {} makes it again", file, stage.name);
    }
    if (!is_forced && is_up_to_date(stage, config, manifest, case_directory)) {
      on_stage({stage.name, true, 0, "unchanged"});
      continue;
    }
    try {
      execute(stage, config, case_directory, manifest, on_stage);
    } catch (...) {
      const Uninterrupted writes;
      const bool has_verdict = stage.name == "gates";
      std::vector<std::string> stale = stages_after(stage.name);
      stale.push_back(stage.name);
      for (const std::string& name : stale) {
        manifest.stages.erase(name);
        if (!(has_verdict && name == stage.name)) remove_outputs(find_stage(name), case_directory);
      }
      write_manifest(case_directory, manifest, config);
      throw;
    }
  }
}

std::vector<std::string> run_one_stage(const std::string& name, const Config& config, const std::filesystem::path& case_directory,
                                       const OnStage& on_stage) {
  const Stage& stage = find_stage(name);
  Manifest manifest = read_manifest(case_directory);
  for (const std::string& need : stage.needs) {
    for (const std::string& file : find_stage(need).outputs) {
      if (!std::filesystem::exists(case_directory / file)) {
        throw IoError((case_directory / file).string() + " is missing; run stage " + need + " first");
      }
    }
  }
  bool is_edited = false;
  for (const std::string& need : stage.needs) {
    for (const std::string& file : changed_outputs(find_stage(need), manifest, case_directory)) {
      spdlog::warn("{} was changed since mvprep wrote it; stage {} uses it as it is", file, stage.name);
      is_edited = true;
    }
  }
  remove_leftovers(case_directory);
  std::vector<std::string> later = stages_after(name);
  if (name != "gates") {
    std::error_code ignored;
    std::filesystem::remove(case_directory / quality_file, ignored);  // its verdict was about something else
  }
  try {
    execute(stage, config, case_directory, manifest, on_stage, !is_edited);
  } catch (...) {
    manifest.stages.erase(name);
    write_manifest(case_directory, manifest, config);
    throw;
  }
  return later;
}

}  // namespace mv

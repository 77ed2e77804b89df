// SPDX-License-Identifier: BSD-3-Clause
#include "geometry/core/log.h"

#include <spdlog/sinks/stdout_color_sinks.h>

#include <memory>

namespace mv {

void set_up_log(LogLevel level) {
  auto logger = std::make_shared<spdlog::logger>("mv", std::make_shared<spdlog::sinks::stderr_color_sink_mt>());
  logger->set_pattern("%^%l%$ %v");
  logger->set_level(level == LogLevel::quiet     ? spdlog::level::warn
                    : level == LogLevel::verbose ? spdlog::level::debug
                                                 : spdlog::level::info);
  logger->flush_on(spdlog::level::info);
  spdlog::set_default_logger(std::move(logger));
}

}  // namespace mv

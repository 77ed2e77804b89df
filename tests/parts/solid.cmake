if(TARGET mv_solid)
  mv_add_test(unit_solid SOURCES unit/solid/pack_test.cpp unit/solid/material_test.cpp unit/solid/leaflet_solid_test.cpp
    unit/solid/distortion_test.cpp unit/solid/stress_test.cpp LIBRARIES mv_solid)
  # GCC 12 warns about its own AVX-512 headers
  target_compile_options(unit_solid PRIVATE -Wno-psabi -Wno-maybe-uninitialized)

  # ninja bench_solid && build/bench_solid
  add_executable(bench_solid EXCLUDE_FROM_ALL unit/solid/bench_solid.cpp)
  target_include_directories(bench_solid PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
  target_link_libraries(bench_solid PRIVATE mv_solid)
  target_compile_options(bench_solid PRIVATE -Wno-psabi -Wno-maybe-uninitialized)
endif()

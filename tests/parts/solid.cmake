if(TARGET mv_solid)
  mv_add_test(unit_solid SOURCES unit/solid/pack_test.cpp unit/solid/material_test.cpp unit/solid/leaflet_solid_test.cpp
    unit/solid/distortion_test.cpp unit/solid/stress_test.cpp LIBRARIES mv_solid)
  target_compile_options(unit_solid PRIVATE -Wno-psabi -Wno-maybe-uninitialized)   # GCC 12 on its own AVX-512 headers
endif()

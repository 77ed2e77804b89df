if(TARGET mv_chordae_geometry)
  mv_add_test(unit_chordae_geometry SOURCES unit/chordae_geometry/insertion_test.cpp unit/chordae_geometry/generic_chordae_test.cpp
    unit/chordae_geometry/chordae_file_test.cpp unit/chordae_geometry/segmented_chordae_test.cpp unit/chordae_geometry/density_chordae_test.cpp
    LIBRARIES mv_chordae_geometry)
endif()
if(TARGET mv_fibers)
  mv_add_test(unit_fibers SOURCES unit/fibers/nematic_test.cpp unit/fibers/fiber_field_test.cpp unit/fibers/guides_test.cpp LIBRARIES mv_fibers)
endif()
if(TARGET mv_chordae_geometry AND TARGET mv_fibers AND TARGET mv_generic AND TARGET mv_volume)
  mv_add_test(unit_chordae_fibers_on_valve SOURCES unit/chordae_geometry/generic_valve_test.cpp
    LIBRARIES mv_chordae_geometry mv_fibers mv_generic mv_volume)
endif()

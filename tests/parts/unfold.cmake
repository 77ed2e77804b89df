if(TARGET mv_unfold)
  mv_add_test(unit_unfold SOURCES unit/unfold/leaflet_surface_test.cpp unit/unfold/leaflet_roles_test.cpp unit/unfold/thickness_limit_test.cpp LIBRARIES mv_unfold mv_chordae_geometry)
endif()

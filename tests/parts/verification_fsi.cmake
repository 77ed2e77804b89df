if(TARGET mv_coupling AND TARGET mv_solid)
  add_library(mv_test_slab OBJECT verification/slab_flow.cpp verification/slab_body.cpp verification/slab_tissue.cpp verification/fsi/channel.cpp verification/fsi/turek_hron.cpp)
  target_link_libraries(mv_test_slab PRIVATE mv_options mv_test_support mv_coupling mv_contact mv_fluid mv_solid)
  foreach(name cylinder ring turek_hron valve_2d)
    mv_add_test(verification_fsi_${name} SOURCES verification/fsi/${name}_test.cpp $<TARGET_OBJECTS:mv_test_slab>
      LIBRARIES mv_coupling mv_contact mv_fluid mv_solid LABEL verification)
  endforeach()
endif()

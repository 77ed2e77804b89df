if(TARGET mv_solid AND TARGET mv_contact)
  set(dry verification/solid/box_mesh.cpp verification/solid/dry_motion.cpp)
  mv_add_test(verification_solid
    SOURCES ${dry} verification/solid/equilibrium.cpp verification/solid/cook_reference.cpp verification/solid/cook_test.cpp
      verification/solid/homogeneous_test.cpp verification/solid/inflation_test.cpp verification/solid/wave_test.cpp
      verification/solid/chordae_test.cpp
    LIBRARIES mv_contact mv_solid mv_chordae LABEL verification)
  mv_add_test(verification_contact
    SOURCES ${dry} verification/contact/hertz_test.cpp verification/contact/incline_test.cpp verification/contact/impact_test.cpp
      verification/contact/serpentine_test.cpp
    LIBRARIES mv_contact mv_solid LABEL verification)
  # GCC 12 warns about its own AVX-512 headers
  target_compile_options(verification_solid PRIVATE -Wno-maybe-uninitialized -Wno-array-bounds)
  target_compile_options(verification_contact PRIVATE -Wno-maybe-uninitialized -Wno-array-bounds)
endif()

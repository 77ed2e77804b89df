if(TARGET mv_coupling AND TARGET mv_solid)
  mv_add_test(verification_two_sheets
    SOURCES verification/two_sheets_test.cpp verification/two_sheets_model.cpp verification/slab_flow.cpp verification/slab_body.cpp verification/slab_tissue.cpp
    LIBRARIES mv_coupling mv_contact mv_fluid mv_solid LABEL verification)
  mv_add_test(verification_leak_band
    SOURCES verification/leak_band_test.cpp verification/slab_flow.cpp verification/slab_body.cpp verification/slab_tissue.cpp
    LIBRARIES mv_coupling mv_contact mv_fluid mv_solid LABEL verification)
  mv_add_test(verification_orifice SOURCES verification/orifice_test.cpp LIBRARIES mv_coupling mv_fluid LABEL verification)
  mv_add_test(verification_moving_annulus SOURCES verification/moving_annulus_test.cpp LIBRARIES mv_coupling mv_fluid LABEL verification)
endif()

if(TARGET mv_seal)
  mv_add_test(unit_seal SOURCES unit/seal/seal_test.cpp unit/seal/holes_test.cpp unit/seal/belt_test.cpp unit/seal/valve_metrics_test.cpp
    LIBRARIES mv_seal)
endif()

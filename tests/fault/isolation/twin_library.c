double twin_value(void) { return PLUMBLINE_TWIN_VALUE; }

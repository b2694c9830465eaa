"""Compliances of any throw within the range of thousands of finite-element answers, by one equation."""
